# SPDX-License-Identifier: MIT
"""The fixture `uno`: one board for every case, simulated or real.

pytest hil_tests --uno=virtual          the simulated Uno, in lock step (default)
pytest hil_tests/cases --uno=PORT       the Uno on that serial port
"""

import pytest

from boards import IMAGE, RealBoard, VirtualBoard

CLOCKWORK = ("rate_sps", "clock_ppm", "jitter_s", "update_pulse_s", "gain_kept")


def pytest_addoption(parser):
    parser.addoption("--uno", default="virtual", help="virtual, or a serial port")


def pytest_configure(config):
    config.addinivalue_line(
        "markers", "board(**how): arguments of virtual_uno.Uno, for the fixture `uno`"
    )


@pytest.fixture
def uno(request):
    """A board that has just started, see boards.Board.

    `@pytest.mark.board(rate_sps=92.0)` makes the simulated one so; a real converter's clock
    cannot be chosen, and such a case then skips. Noise a real one has of its own.
    """
    marker = request.node.get_closest_marker("board")
    how = dict(marker.kwargs) if marker else {}
    port = request.config.getoption("--uno")
    if port != "virtual":
        if chosen := sorted(set(how) & set(CLOCKWORK)):
            pytest.skip(f"a real board's converter is as it is: {', '.join(chosen)}")
        board = RealBoard(port)
    else:
        if not IMAGE.exists():
            pytest.fail("there is no firmware image: make -C firmware", pytrace=False)
        board = VirtualBoard(**how)
    yield board
    board.close()
