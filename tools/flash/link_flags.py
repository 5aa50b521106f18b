# SPDX-License-Identifier: MIT
"""PlatformIO script: what decides the code decides it at link time too, as in firmware/Makefile.

The image is optimised across sources when it is linked, and PlatformIO hands `build_flags` to the
compiler alone. Runs after the platform has taken them.
"""

Import("env")  # noqa: F821 - SCons gives it to the script

AT_LINK_TIME = ("-O", "-flto", "-mcall-", "-mstrict-", "-ffunction-", "-fdata-")

flags = [str(flag) for flag in env["CCFLAGS"]]  # noqa: F821
env.Append(LINKFLAGS=[flag for flag in flags if flag.startswith(AT_LINK_TIME)])  # noqa: F821
