# SPDX-License-Identifier: MIT
"""A recording as one page that opens by itself from disk: figures, tables, no network."""

from terazi.report.analysis import Analysis, analyse
from terazi.report.page import write_report
from terazi.report.truth import Truth, load_truth

__all__ = ["Analysis", "Truth", "analyse", "load_truth", "write_report"]
