# SPDX-License-Identifier: MIT
"""Each law of the code can fail: layers, format, lint, warnings, names in the image."""

import subprocess
from pathlib import Path

import pytest

from tools.checks import compiled, form, layers

ROOT = Path(__file__).resolve().parents[3]


def plant(root: Path, name: str, text: str) -> Path:
    path = root / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return root


@pytest.fixture
def house(tmp_path):
    """One header a room, none in breach."""
    plant(tmp_path, "shared_c/include/fir.h", "#ifndef FIR_H\n#define FIR_H\n#endif\n")
    plant(tmp_path, "shared_c/src/fir.c", '#include "fir.h"\n#include "port_rom.h"\n')
    plant(tmp_path, "firmware/drivers/uart.h", "#include <stdint.h>\n")
    plant(tmp_path, "firmware/drivers/uart.c", '#include <avr/io.h>\n#include "uart.h"\n')
    plant(tmp_path, "firmware/app/main.c", '#include "fir.h"\n#include "uart.h"\n')
    plant(tmp_path, "firmware/port/port_rom.h", "#include <avr/pgmspace.h>\n")
    return tmp_path


def test_the_arrows_of_the_house_are_allowed(house):
    assert layers.breaches(house) == []


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("shared_c/src/fir.c", "#include <avr/io.h>\n"),
        ("shared_c/src/fir.c", "#include <stdio.h>\n"),
        ("shared_c/src/fir.c", '#include "uart.h"\n'),
        ("shared_c/src/fir.c", "#ifdef __AVR__\n#endif\n"),
        ("shared_c/src/fir.c", "#if defined(ARDUINO)\n#endif\n"),
        ("shared_c/include/fir.h", '#include "port_rom.h"\n'),
        ("firmware/drivers/uart.c", '#include "fir.h"\n'),
        ("firmware/app/main.c", "#include <avr/io.h>\n"),
        ("firmware/app/main.c", "#include <avr/interrupt.h>\n"),
        ("firmware/port/port_rom.h", '#include "uart.h"\n'),
    ],
)
def test_an_arrow_against_the_layers_is_named(house, file, text):
    assert len(layers.breaches(plant(house, file, text))) == 1


@pytest.mark.parametrize(
    ("law", "file", "fine", "broken"),
    [
        (form.c_format, "a.c", "int32_t x;\n", "int32_t    x ;\n"),
        (form.python_format, "a.py", "x = 1\n", "x=1\n"),
        (form.python_lint, "a.py", "x = 1\n", "import os\nx = 1\n"),
    ],
)
def test_format_and_lint_are_held(tmp_path, law, file, fine, broken):
    plant(tmp_path, ".clang-format", (ROOT / ".clang-format").read_text(encoding="utf-8"))
    plant(tmp_path, "pyproject.toml", "[tool.ruff.lint]\nselect = ['F']\n")
    assert law(plant(tmp_path, file, fine)) == []
    assert law(plant(tmp_path, file, broken)) != []


def test_a_tool_that_fails_without_a_word_is_not_taken_for_success(tmp_path):
    assert form.complaints(["false"], tmp_path) == ["false exited with 1"]


@pytest.mark.parametrize(
    "body",
    [
        "int16_t f(int32_t x) { return x; }",
        "int32_t f(int32_t x) { int32_t y; return x + y; }",
        "static int32_t f(int32_t x) { return x; }",
        "double f(float x) { return x * 2.0; }",
    ],
)
def test_a_warning_of_the_host_compiler_is_named(tmp_path, body):
    source = "shared_c/src/f.c"
    fine = "#include <stdint.h>\nint32_t f(int32_t x);\nint32_t f(int32_t x) { return x; }\n"
    assert compiled.host_warnings(plant(tmp_path, source, fine)) == []
    assert compiled.host_warnings(plant(tmp_path, source, f"#include <stdint.h>\n{body}\n")) != []


def avr_link(root: Path, source: str, *options: str) -> None:
    """`source` as the image, with its object kept beside it."""
    plant(root, "f.c", source)
    folder = (root / compiled.IMAGE).parent
    folder.mkdir(parents=True, exist_ok=True)
    avr = ["avr-gcc", "-mmcu=atmega328p", "-O1", *options]
    subprocess.run([*avr, "-c", "f.c", "-o", str(folder / "f.o")], cwd=root, check=True)
    linked = [*avr, str(folder / "f.o"), "-o", str(root / compiled.IMAGE)]
    subprocess.run(linked, cwd=root, check=True)


PLAIN = "volatile {type} a, b; int main(void) {{ a = {expression}; }}"


@pytest.mark.parametrize(
    ("type_name", "expression", "name"),
    [
        ("long", "a / b", "__divmodsi4"),
        ("int", "a % b", "__divmodhi4"),
        ("float", "a + b", "__addsf3"),
        ("float", "a / b", "__divsf3"),
        ("long long", "a / b", "__divdi3"),
        ("int", "(int)__builtin_malloc((unsigned)b)", "malloc"),
    ],
)
def test_a_forbidden_routine_is_named(tmp_path, type_name, expression, name):
    plant(tmp_path, "shared_c/src/f.c", "")
    avr_link(tmp_path, PLAIN.format(type="long", expression="a * b + 3"))
    assert compiled.image_laws(tmp_path) == []
    avr_link(tmp_path, PLAIN.format(type=type_name, expression=expression))
    assert any(name in breach for breach in compiled.image_laws(tmp_path))


def test_an_image_that_is_not_built_is_no_image_without_faults(tmp_path):
    assert compiled.image_laws(tmp_path) == [f"{compiled.IMAGE} is not built"]
