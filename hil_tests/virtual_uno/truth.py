# SPDX-License-Identifier: GPL-3.0-or-later
"""A CSV of what truly happened, a row for each conversion since the last reset."""

HEADER = "t_s,load_g,counts\n"


class TruthFile:
    """``t_s`` since reset, ``load_g`` without vibration and noise, ``counts`` as converted.

    Each reset starts the file anew, as it starts the program and the scenario anew.
    """

    def __init__(self, path, uno, scenario):
        self._file = open(path, "w")  # noqa: SIM115 - close() closes it
        self._uno = uno
        self._scenario = scenario
        self.restart()

    def restart(self):
        """Forget all rows; the next conversion is the first."""
        self._file.seek(0)
        self._file.truncate()
        self._file.write(HEADER)
        self._next = self._uno.conversion_count
        self._reset_s = self._uno.seconds

    def write(self):
        """Append the conversions that have come since."""
        rows = self._uno.conversions_since(self._next)
        if not len(rows):
            return
        self._next += len(rows)
        at_s = rows["time_s"] - self._reset_s
        load_g = self._scenario.truth_g(at_s)
        self._file.writelines(
            f"{t:.7f},{g:.6g},{c}\n" for t, g, c in zip(at_s, load_g, rows["counts"], strict=True)
        )
        self._file.flush()

    def close(self):
        """Write the rest and close."""
        self.write()
        self._file.close()
