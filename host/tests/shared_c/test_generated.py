# SPDX-License-Identifier: MIT
"""tools/gen: what is committed is what the specifications give, and nonsense is refused."""

import dataclasses
import shutil

import pytest

from tools.gen import golden, messages_spec, run
from tools.gen.spec import ROOT, SPEC_DIR, Spec, SpecError, load


def test_generated_files_are_those_of_the_specifications():
    assert run.stale() == []


def test_a_changed_or_missing_output_is_named_as_stale(tmp_path):
    for path in run.outputs():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / path, tmp_path / path)
    assert run.stale(tmp_path) == []
    edited, missing = "shared_c/generated/messages.c", "shared_c/PROTOCOL.md"
    (tmp_path / edited).write_text((tmp_path / edited).read_text() + "\n")
    (tmp_path / missing).unlink()
    assert sorted(run.stale(tmp_path)) == sorted([edited, missing])


def test_every_output_carries_its_specification_hash_in_line_one():
    for path, text in run.outputs().items():
        first_line = text.splitlines()[0]
        specs = sorted((each.stem for each in SPEC_DIR.glob("*.toml")), key=len, reverse=True)
        # fir_designs.c and port_fir_default.S are of fir.toml, PROTOCOL.md of messages.toml
        file_name = path.split("/")[-1].removeprefix("port_")
        name = next((each for each in specs if file_name.startswith(each)), "messages")
        assert load(name).sha256[:16] in first_line, path


def test_vectors_are_those_that_their_generator_gives():
    """Twins, designs and vectors belong together: a change of one moves the truth visibly."""
    expected = {f"{draft.name}.csv": golden.text_of(draft, "") for draft in golden.drafts()}
    present = {path.name: path.read_text() for path in golden.FOLDER.glob("*.csv")}
    assert sorted(present) == sorted(expected)
    for name, text in expected.items():
        assert golden.content(present[name]) == golden.content(text), name


def changed(**tables) -> Spec:
    spec = load("messages")
    return dataclasses.replace(spec, content=spec.content | tables)


FIELD = {"name": "value", "type": "u8"}


def message(**parts) -> dict:
    return {"id": 1, "name": "m", "direction": "to_host", "summary": "s", "fields": []} | parts


@pytest.mark.parametrize(
    ("spec", "complaint"),
    [
        (changed(message=[message(fields=[FIELD | {"type": "f32"}])]), "unknown type f32"),
        (changed(message=[message(fields=[FIELD | {"enum": "none"}])]), "unknown enum"),
        (changed(message=[message(fields=[FIELD | {"range": [0, 256]}])]), "does not fit"),
        (changed(message=[message(fields=[FIELD | {"range": [2, 1]}])]), "does not fit"),
        (changed(message=[message(fields=[FIELD, FIELD])]), "two fields of one name"),
        (changed(message=[message(direction="sideways")]), "unknown direction"),
        (changed(message=[message(), message(name="n")]), "one id"),
        (changed(message=[message(), message(id=2)]), "one name"),
        (
            changed(
                message=[
                    message(fields=[FIELD | {"name": f"v{n}", "type": "u32"} for n in range(13)])
                ]
            ),
            "52 bytes > 48",
        ),
        (
            changed(enum=[{"name": "e", "values": [{"name": n, "value": 1} for n in "ab"]}]),
            "two names",
        ),
        (
            changed(
                enum=[{"name": "e", "values": [{"name": "a", "value": 256}]}],
                message=[message(fields=[FIELD | {"enum": "e"}])],
            ),
            "e does not fit in u8",
        ),
        (
            changed(
                flags=[{"name": "f", "values": [{"name": "a", "bit": 16}]}],
                message=[message(fields=[FIELD | {"type": "u16", "flags": "f"}])],
            ),
            "f does not fit in u16",
        ),
    ],
)
def test_a_specification_that_contradicts_itself_is_refused(spec, complaint):
    with pytest.raises(SpecError, match=complaint):
        messages_spec.parse(spec)


def test_check_writes_nothing_and_fails_when_stale(monkeypatch, capsys):
    written = {path: (ROOT / path).stat().st_mtime_ns for path in run.outputs()}
    assert run.main(["--check"]) == 0
    monkeypatch.setattr(run, "outputs", lambda: {"shared_c/generated/messages.c": "other"})
    assert run.main(["--check"]) == 1
    assert "stale: shared_c/generated/messages.c" in capsys.readouterr().err
    assert written == {path: (ROOT / path).stat().st_mtime_ns for path in written}
