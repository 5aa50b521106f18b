# SPDX-License-Identifier: MIT
"""The figures of a report: steps, settling time, noise, spectrum, timing. No plots here.

Definitions, which the page repeats for its readers:
  step      a change of load; from the truth where there is one, else found in the raw signal
  plateau   from one step to the next; settled SETTLED_AFTER_S after the step, for its level also
            after half of it
  settling  from the step to the first sample from which on a stage stays within BAND_SHARE of
            the step around the plateau's settled mean; never, if it still leaves that band in
            the second half of the plateau
  noise     rms about a straight line through the settled part of each plateau, pooled
"""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from terazi import units
from terazi.design import scale as scale_design
from terazi.link.generated.messages import SampleFlag
from terazi.models import scale as scale_model
from terazi.recorder.calibration import calibration_of
from terazi.recorder.recording import Recording
from terazi.report.truth import Truth, align

STAGES = ("raw", "fir", "kalman")
BAND_SHARE = 0.01
SETTLED_AFTER_S = 2.0
QUIET_LEAST_SAMPLES = 32
STEP_WINDOW_S = 0.4
STEP_SIGMAS = 10.0
STEP_LEAST_COUNTS = 100.0  # smaller changes are not told from creep
STEP_SWING_WIDTHS = 3  # for so many windows a pan may swing after a step,
STEP_SWING_SHARE = 0.25  # with less than this share of it
SPECTRUM_SEGMENT = 256
RATE_WINDOW_S = 1.0


@dataclass(frozen=True)
class Step:
    """One change of load. settling_s: per stage, None where it never settles."""

    t_s: float
    from_g: float
    to_g: float
    settling_s: dict[str, float | None]

    @property
    def size_g(self) -> float:
        return self.to_g - self.from_g


@dataclass
class Analysis:
    """Everything that the page shows, in gram and seconds."""

    t_s: np.ndarray  # (n,) device time since the first sample
    stages_g: dict[str, np.ndarray]  # per stage (n,)
    truth_g: np.ndarray | None  # (n,), NaN outside the truth
    truth_shift_s: float
    rate_hz: float
    interval_ms: np.ndarray  # (n-1,) between neighbouring conversions; NaN across a loss
    steps: list[Step]
    spans: list[tuple[int, int]]  # from one step to the next, [begin, end) in samples
    settled: list[tuple[int, int]]  # of each the part that tells its level
    plateaus: list[tuple[int, int]]  # those that tell noise
    noise_rms_g: dict[str, float]
    noise_p2p_g: dict[str, float]
    truth_error_g: dict[str, float] = field(default_factory=dict)  # rms when settled
    spectrum_hz: np.ndarray = field(default_factory=lambda: np.zeros(0))
    spectrum_g_rthz: dict[str, np.ndarray] = field(default_factory=dict)


def analyse(recording: Recording, truth: Truth | None = None) -> Analysis:
    """Everything in one go. A short or monotonous recording has fewer figures, never an error."""
    samples = recording.samples
    t_s = time_s(samples)
    stages_g = weights_g(recording)
    interval_ms = intervals_ms(samples)
    rate_hz = rate_of(interval_ms)
    shift_s, truth_g = 0.0, None
    if truth is not None:
        shift_s = align(truth, t_s, stages_g["raw"], rate_hz)
        truth = truth.shifted(shift_s)
        truth_g = truth.at(t_s)
    edges_s = truth_steps_s(truth, t_s) if truth else found_steps_s(t_s, samples, rate_hz)
    spans = _spans(t_s, edges_s)
    settled = [_settled_part(t_s, span) for span in spans]
    plateaus = [_quiet_part(t_s, span) for span in spans]
    plateaus = [part for part in plateaus if part[1] - part[0] >= QUIET_LEAST_SAMPLES]
    result = Analysis(
        t_s=t_s,
        stages_g=stages_g,
        truth_g=truth_g,
        truth_shift_s=shift_s,
        rate_hz=rate_hz,
        interval_ms=interval_ms,
        steps=_steps(t_s, stages_g, edges_s, spans, settled),
        spans=spans,
        settled=settled,
        plateaus=plateaus,
        noise_rms_g={stage: noise_rms(stages_g[stage], plateaus) for stage in STAGES},
        noise_p2p_g={stage: noise_p2p(stages_g[stage], plateaus) for stage in STAGES},
    )
    if truth_g is not None:
        result.truth_error_g = {
            stage: _rms_error(stages_g[stage], truth_g, plateaus) for stage in STAGES
        }
    result.spectrum_hz, result.spectrum_g_rthz = spectra(stages_g, plateaus, rate_hz)
    return result


def time_s(samples: dict[str, np.ndarray]) -> np.ndarray:
    """Device time since the first sample. Runs of the device are set apart by the host's clock."""
    device_s = units.s_from_us(samples["device_us"].astype(np.float64))
    host_s, boot = samples["host_s"], samples["boot"]
    _boots, first, which = np.unique(boot, return_index=True, return_inverse=True)
    return device_s - device_s[first][which] + (host_s[first] - host_s[0])[which]


def weights_g(recording: Recording) -> dict[str, np.ndarray]:
    """Each stage in net gram, by the calibration, zero and tare that held at the time.

    Where no calibration is told, by that of a board which was never calibrated.
    """
    samples = recording.samples
    counts = {
        "raw": samples["raw_counts"].astype(np.float64),
        "fir": samples["fir_counts"].astype(np.float64),
        "kalman": units.counts_from_q7(samples["kf_counts_q7"].astype(np.float64)),
    }
    away_mg = samples["mass_mg"] - samples["net_mg"].astype(np.float64)  # zero and tare
    nominal = [(at, mass_g * units.MG_PER_G) for at, mass_g in scale_design.default_points()]
    stages_g = {stage: np.empty(len(away_mg)) for stage in counts}
    for stretch in calibration_of(recording):
        points = nominal
        if stretch.points is not None:
            points = [(units.counts_from_q7(at_q7), mass_mg) for at_q7, mass_mg in stretch.points]
        place = slice(stretch.begin, stretch.end)
        for stage, values in counts.items():
            net_mg = scale_model.mass_mg(values[place], points) - away_mg[place]
            stages_g[stage][place] = units.g_from_mg(net_mg)
    return stages_g


def intervals_ms(samples: dict[str, np.ndarray]) -> np.ndarray:
    """Time between one conversion and the next; NaN where one or more are missing."""
    step = np.diff(samples["conversion"].astype(np.int64)) % (1 << 16)
    same_run = np.diff(samples["boot"]) == 0
    between_ms = np.diff(samples["device_us"]) / 1000.0
    return np.where((step == 1) & same_run, between_ms, np.nan)


def rate_of(interval_ms: np.ndarray) -> float:
    """Conversions a second over the whole recording; 0 if no two samples follow each other."""
    known = interval_ms[np.isfinite(interval_ms)]
    return 1000.0 / float(known.mean()) if len(known) and known.mean() > 0 else 0.0


def rate_over_time(t_s: np.ndarray, interval_ms: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rate in windows of RATE_WINDOW_S: their middles, and conversions a second in each."""
    slot = np.floor((t_s[1:] - t_s[0]) / RATE_WINDOW_S).astype(np.int64)
    known = np.isfinite(interval_ms)
    if not known.any():
        return np.zeros(0), np.zeros(0)
    count = np.bincount(slot[known])
    total_ms = np.bincount(slot[known], weights=interval_ms[known])
    full = count > 1
    middle_s = t_s[0] + (np.flatnonzero(full) + 0.5) * RATE_WINDOW_S
    return middle_s, 1000.0 * count[full] / total_ms[full]


def truth_steps_s(truth: Truth, t_s: np.ndarray) -> np.ndarray:
    """Where the truth changes, within the recording."""
    edges = truth.t_s[1:][np.diff(truth.load_g) != 0]
    return edges[(edges > t_s[0]) & (edges < t_s[-1])]


def found_steps_s(t_s: np.ndarray, samples: dict, rate_hz: float) -> np.ndarray:
    """Changes of load in the raw signal: where the means before and after differ the most."""
    raw = samples["raw_counts"].astype(np.float64)
    width = max(4, round(STEP_WINDOW_S * rate_hz))
    if len(raw) < 4 * width:
        return np.zeros(0)
    total = np.concatenate([[0.0], np.cumsum(raw - raw[0])])
    mean = (total[width:] - total[:-width]) / width
    change = np.abs(mean[width:] - mean[:-width])  # at sample width + i
    least = max(STEP_SIGMAS * 1.4826 * np.median(change), STEP_LEAST_COUNTS)
    edges = []
    while change.max() > least:
        at = int(np.argmax(change))
        edges.append(at + width)
        # A pan that swings after a step is no second step, unless it is a large one.
        around = slice(max(0, at - STEP_SWING_WIDTHS * width), at + STEP_SWING_WIDTHS * width)
        change[around][change[around] < STEP_SWING_SHARE * change[at]] = 0.0
        change[max(0, at - width) : at + width] = 0.0
    # A restart is no change of load: the filters begin anew with it.
    restarted = np.flatnonzero(samples["flags"] & int(SampleFlag.RESTARTED))
    edges = [at for at in sorted(edges) if np.abs(restarted - at).min(initial=width) >= width // 2]
    return t_s[edges]


def _spans(t_s: np.ndarray, edges_s: np.ndarray) -> list[tuple[int, int]]:
    """Samples between steps, [begin, end); one more than there are steps."""
    cuts = [0, *np.searchsorted(t_s, edges_s).tolist(), len(t_s)]
    return list(pairwise(cuts))


def _settled_part(t_s: np.ndarray, span: tuple[int, int]) -> tuple[int, int]:
    """For a plateau's level: what is left after SETTLED_AFTER_S, or after half of it."""
    begin, end = span
    if end <= begin:
        return begin, begin
    wait_s = min(SETTLED_AFTER_S, (t_s[end - 1] - t_s[begin]) / 2)
    return begin + int(np.searchsorted(t_s[begin:end], t_s[begin] + wait_s)), end


def _quiet_part(t_s: np.ndarray, span: tuple[int, int]) -> tuple[int, int]:
    """For noise: what is left after SETTLED_AFTER_S; a filter still on its way is no noise."""
    begin, end = span
    if end <= begin:
        return begin, begin
    return begin + int(np.searchsorted(t_s[begin:end], t_s[begin] + SETTLED_AFTER_S)), end


def _steps(t_s, stages_g, edges_s, spans, settled) -> list[Step]:
    steps = []
    for number, edge_s in enumerate(edges_s):
        before, after = settled[number], settled[number + 1]
        if before[1] - before[0] < 2 or after[1] - after[0] < 2:
            continue  # too close to its neighbour or to the end for a level of its own
        from_g = float(stages_g["kalman"][slice(*before)].mean())
        to_g = float(stages_g["kalman"][slice(*after)].mean())
        begin, end = spans[number + 1]
        settling = {
            stage: settling_time(
                t_s[begin:end] - edge_s,
                stages_g[stage][begin:end] - to_g,
                BAND_SHARE * abs(to_g - from_g),
            )
            for stage in STAGES
        }
        steps.append(Step(float(edge_s), from_g, to_g, settling))
    return steps


def settling_time(since_s: np.ndarray, error_g: np.ndarray, band_g: float) -> float | None:
    """When the error comes within the band for good; None if it still leaves it in the second
    half: then it is chance that keeps it within, not settling."""
    outside = np.flatnonzero(np.abs(error_g) > band_g)
    if not len(outside):
        return max(float(since_s[0]), 0.0)
    if outside[-1] + 1 > len(error_g) // 2:
        return None
    return float(since_s[outside[-1] + 1])


def _residuals(values_g: np.ndarray, plateaus: list[tuple[int, int]]) -> list[np.ndarray]:
    """Each plateau less a straight line through it: noise without creep."""
    parts = []
    for begin, end in plateaus:
        part = values_g[begin:end]
        place = np.arange(len(part)) - (len(part) - 1) / 2
        slope = (place @ part) / (place @ place)
        parts.append(part - part.mean() - slope * place)
    return parts


def noise_rms(values_g: np.ndarray, plateaus: list[tuple[int, int]]) -> float:
    """Pooled rms; NaN without a plateau."""
    parts = _residuals(values_g, plateaus)
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2))) if parts else float("nan")


def noise_p2p(values_g: np.ndarray, plateaus: list[tuple[int, int]]) -> float:
    """The widest plateau from peak to peak; NaN without one."""
    return max((float(np.ptp(part)) for part in _residuals(values_g, plateaus)), default=np.nan)


def _rms_error(values_g: np.ndarray, truth_g: np.ndarray, plateaus: list) -> float:
    errors = [values_g[begin:end] - truth_g[begin:end] for begin, end in plateaus]
    error = np.concatenate(errors) if errors else np.zeros(0)
    error = error[np.isfinite(error)]
    return float(np.sqrt(np.mean(error**2))) if len(error) else float("nan")


def spectra(stages_g: dict, plateaus: list, rate_hz: float) -> tuple[np.ndarray, dict]:
    """Amplitude spectral density of each stage over the plateaus, in g/sqrt(Hz).

    Welch 1967: Hann windows, half overlapped, each less its line; the segment is halved until a
    plateau is long enough for it. Empty if none is.
    """
    longest = max((end - begin for begin, end in plateaus), default=0)
    size = SPECTRUM_SEGMENT
    while size > longest:
        size //= 2
    if size < 32 or rate_hz <= 0:
        return np.zeros(0), {}
    window = np.hanning(size + 1)[:-1]
    scale = 2.0 / (rate_hz * (window @ window))
    density = {}
    for stage, values_g in stages_g.items():
        starts = [
            (at, at + size)
            for begin, end in plateaus
            for at in range(begin, end - size + 1, size // 2)
        ]
        segments = np.array(_residuals(values_g, starts)) * window
        power = np.mean(np.abs(np.fft.rfft(segments, axis=1)) ** 2, axis=0) * scale
        density[stage] = np.sqrt(power)[1:]
    return np.fft.rfftfreq(size, 1.0 / rate_hz)[1:], density
