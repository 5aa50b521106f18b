# SPDX-License-Identifier: MIT
"""PlatformIO builder of the platform `uno_system`: tools from PATH, flags from platformio.ini.

SCons runs this file with PlatformIO's environment. It holds only what makes an AVR build an AVR
build; whatever decides the code (optimisation, standard, warnings) stands in platformio.ini, so
that the registry's platform and this one receive the same.
"""

from os.path import join

from SCons.Script import (
    COMMAND_LINE_TARGETS,
    AlwaysBuild,
    Builder,
    Default,
    DefaultEnvironment,
)

env = DefaultEnvironment()

env.Replace(
    AR="avr-gcc-ar",
    AS="avr-as",
    CC="avr-gcc",
    CXX="avr-g++",
    GDB="avr-gdb",
    OBJCOPY="avr-objcopy",
    RANLIB="avr-gcc-ranlib",
    SIZETOOL="avr-size",
    ARFLAGS=["rc"],
    PROGNAME="firmware",
    PROGSUFFIX=".elf",
    # .data counts twice: its initial values lie in flash, its variables in RAM.
    SIZEPROGREGEXP=r"^(?:\.text|\.data|\.bootloader)\s+(\d+).*",
    SIZEDATAREGEXP=r"^(?:\.data|\.bss|\.noinit)\s+(\d+).*",
    SIZECHECKCMD="$SIZETOOL -A -d $SOURCES",
    SIZEPRINTCMD="$SIZETOOL --mcu=$BOARD_MCU -C -d $SOURCES",
    UPLOADER="avrdude",
    # -D: optiboot erases page by page and knows no chip erase.
    UPLOADERFLAGS=["-p", "$BOARD_MCU", "-c", "$UPLOAD_PROTOCOL", "-b", "$UPLOAD_SPEED", "-D"],
    UPLOADCMD="$UPLOADER $UPLOADERFLAGS -U flash:w:$SOURCES:i",
)

machine_flags = ["-mmcu=$BOARD_MCU"]
env.Append(
    ASFLAGS=machine_flags,
    ASPPFLAGS=["-x", "assembler-with-cpp"],
    CCFLAGS=machine_flags,
    CPPDEFINES=[("F_CPU", "$BOARD_F_CPU")],
    LINKFLAGS=machine_flags,
    BUILDERS={
        "ElfToHex": Builder(
            action=env.VerboseAction(
                "$OBJCOPY -O ihex -R .eeprom $SOURCES $TARGET", "Building $TARGET"
            ),
            suffix=".hex",
        )
    },
)

if "nobuild" in COMMAND_LINE_TARGETS:
    elf = join("$BUILD_DIR", "${PROGNAME}.elf")
    image = join("$BUILD_DIR", "${PROGNAME}.hex")
else:
    elf = env.BuildProgram()
    image = env.ElfToHex(join("$BUILD_DIR", "${PROGNAME}"), elf)
    env.Depends(image, "checkprogsize")

AlwaysBuild(env.Alias("nobuild", image))
program = env.Alias("buildprog", image, image)


def choose_port(target, source, env):
    """Put the port that PlatformIO found, or was told, on avrdude's command line."""
    env.AutodetectUploadPort()
    env.Append(UPLOADERFLAGS=["-P", "$UPLOAD_PORT"])


env.AddPlatformTarget(
    "upload",
    image,
    [
        env.VerboseAction(choose_port, "Looking for upload port..."),
        env.VerboseAction("$UPLOADCMD", "Uploading $SOURCE"),
    ],
    "Upload",
)
size = env.AddPlatformTarget(
    "size", elf, env.VerboseAction("$SIZEPRINTCMD", "Calculating size $SOURCE"), "Program size"
)

Default([program, size])
