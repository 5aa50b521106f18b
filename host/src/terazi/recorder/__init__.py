# SPDX-License-Identifier: MIT
"""Recordings: the bytes as they came in, with their time, and tables made of them.

The raw capture is the source of truth. Tables can be made anew from it at any time.
"""

from terazi.recorder.capture import Capture, CaptureWriter
from terazi.recorder.recorder import Recorder
from terazi.recorder.recording import Recording, load_recording

__all__ = ["Capture", "CaptureWriter", "Recorder", "Recording", "load_recording"]
