"""All thresholds of the diagnosis, by step; each with its unit, its meaning and, in brackets, what set it.

Units: `ln p` is the ln of the probability that noise alone shows as much, `T` a score test's statistic, `score` the
penalised 2 ln likelihood of a finding, `1` a plain ratio or number. What set them: `tuned` values were set together on
the tuning seeds of the blind suite (tests/blind/seeds.toml) and frozen before a seed was drawn for a report. `exact`
ones are mathematics. `cost` ones save time; what a larger value would find, nobody measured. `drawn` ones are how a
result is shown. `assumed` ones were chosen by judgement: no data are on record.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class DistributionConstants:
    """Constants of distributions by which levels of noise are read from medians: no thresholds."""

    chi_square_median: float = 0.4549  # 1: median of chi-square with one degree of freedom [exact]
    chi_square_hundredth: float = 6.635  # 1: 99 of 100 values of it are below [exact]
    normal_quartiles: float = 1.349  # 1: standard deviations between the quartiles of a normal distribution [exact]
    normal_median: float = 1.4826  # 1: its standard deviation over its median size [exact]


# Evidence -------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class PreparationThresholds:
    """Which logs can be diagnosed at all."""

    rows_min: int = 500  # rows: a log must have [assumed]
    motion_min: float = 1.0  # s: in motion, in all given logs together; less is insufficient excitation [assumed]
    motion_steps: int = 2000  # 1: steps into which a log is cut to see in which the axis moves [assumed]
    motion_speed: float = 0.01  # of the largest mean speed of a step: from there the axis moves [assumed]
    command_missed: float = 1e-3  # of the rms command: a controller that misses more has its gains refitted [assumed]


@dataclass(frozen=True)
class PhysicalThresholds:
    """What no machine that made these logs can be."""

    periods: float = 3.0  # 1: of a tone or a resonance, that the time of motion holds: fewer are a drift [assumed]
    levels: int = 20  # 1: of the command, at which is seen whether what is beyond them acts [cost]
    averaged: tuple[int, ...] = (1, 2, 4, 8, 16, 32)  # rows: over which commands and readings are averaged [cost]
    fewest: int = 40  # 1: times the rows averaged, that a log has at least [assumed]
    obeyed: float = 0.5  # 1: of what a V up to a level does, that a V beyond it does if there is no limit [assumed]
    certain: float = 8.0  # deviations: by which what is beyond a level acts [assumed]
    stands_at: float = 1e-3  # 1: relative; so near to an end a parameter stands at it [assumed]
    friction_places: int = 60  # 1: of the travel, at which the level of friction is looked at [cost]
    friction_pushes: float = 0.02  # of the largest command: so far below nothing friction may come out [assumed]


@dataclass(frozen=True)
class ObserverThresholds:
    """The observers whose innovations are the residual, and the rows that count."""

    quick_bandwidth: float = 100.0  # Hz: above the motion, below what a coarse encoder makes noisy [assumed]
    calm_bandwidth: float = 50.0  # Hz: the same where rows soon after a start are left out [assumed]
    gap_bandwidth: float = 15.0  # Hz: of that whose innovations are the gap where no controller is known [assumed]
    turning_bandwidth: float = 50.0  # Hz: the same for an axis that keeps turning back [assumed]
    bandwidth_of_rate: float = 0.05  # of the sample rate: no bandwidth is higher [assumed]
    moving_rows: float = 0.1  # of the rows: fewer in motion ask for the faster observer, then for less rest [assumed]
    rest_of_speed: float = 3e-3  # of the log's speed: below it is rest, where rest took too many rows [assumed]


@dataclass(frozen=True)
class NullThresholds:
    """The re-tuned model that stands for nothing missing."""

    first_iterations: int = 2  # 1: of a fit, after which a form of friction that is `hopeless` is given up [cost]
    hopeless: float = 1000.0  # 2 ln likelihood: behind by more, it is so [at most 200 to gain then on 40 blind logs]
    form_gain: float = 5.0  # of the cost: by so much another form of friction must fit better [assumed]
    other_width: float = 0.005  # of the largest speed: friction width that stands beside sticking [assumed]
    width_of_rest: float = 0.2  # of the slowest row that counts: narrower friction is an axis that sticks [assumed]
    time_gap: float = 5.0  # median steps: a longer one is a gap in time [assumed]
    starts_power: float = 1.5  # times the power of other rows, or its inverse: rows after starts are alike [assumed]
    speed_window: float = 0.01  # s: over which positions are averaged to tell the largest speed [assumed]


@dataclass(frozen=True)
class WhiteningThresholds:
    """The filters that make a residual white."""

    band_lines: int = 12  # 1: lines of a periodogram in a band of its level, at least [assumed]
    band_ratio: float = 1.26  # 1: highest over lowest frequency of a band, a third of an octave [exact]
    band_level_min: float = 1e-3  # 1: level of a band, against white noise, of what the first filter left [assumed]
    outlier: float = 6.0  # rms of the whitened residual: larger ones are cut there for the filters [assumed]
    glitch: float = 20.0  # rms of the whitened residual: beyond it a row is cut there, for it is no effect [assumed]
    friction_decays: tuple[float, ...] = (0.5, 1.0, 2.0, 4.0)  # widths: exp(-(v / w)^2) near rest is free [assumed]
    friction_tails: tuple[float, ...] = (1.0, 3.0)  # widths: v w / (v^2 + w^2) near rest is free [assumed]
    refit_rank: float = 1e-9  # of the largest singular value: what re-tuning makes of a residual [assumed]


@dataclass(frozen=True)
class ScoreTestThresholds:
    """Score tests, and the scatter of the scores."""

    columns_together: int = 8  # 1: columns that are whitened at once [cost]
    bytes_kept: float = 4e7  # bytes: of columns that are quick to make again, kept for the next scan [cost]
    effects_below: float = 60.0  # Hz: effects are slower; power and scatter are taken below [assumed]
    effects_above: float = 0.5  # Hz: the scatter of the scores is taken above [assumed]
    scatter_lines: int = 20  # 1: lines between the two, of which more must be for the scatter to be told [assumed]
    untuned_share: float = 2e-3  # of a column's size: what re-tuning leaves of it must be larger [assumed]
    column_rank: float = 1e-4  # eigenvalue of the columns' correlation: smaller directions are left out [assumed]
    basis_rank: float = 1e-9  # of the largest eigenvalue: smaller ones are rounding [assumed]


# Scan -----------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class GridThresholds:
    """Shapes at which an effect is first tried."""

    turns_to_change: float = 3.0  # turns in the travel: a wave needs for its amplitude to change along it [assumed]
    nodes: int = 6  # 1: places along the travel of an amplitude that is a list [assumed]
    values_of_shape: tuple[int, ...] = (3, 12, 4, 2, 3)  # 1: each, for 0, 1, 2, 3 and more shape numbers [cost]
    moments: int = 10  # 1: at which something may begin or end [cost]
    resonances: int = 96  # 1: frequencies that are tried of a resonance, for it is narrow [assumed]
    first_damping: float = 0.03  # 1: damping ratio of a resonance, to begin with [assumed]
    small: float = 0.02  # 1: of what is relative and starts from nothing: columns are nearly linear in it [assumed]
    unit_share: float = 0.02  # of the largest amplitude: a column is made with it [assumed]
    exponents: tuple[float, ...] = (1.0, 2.0)  # 1: that are tried [assumed]
    assumed_friction: float = 0.1  # of the largest command: friction of a model that has none [assumed]
    limit_nearest: float = 0.005  # of the largest command below it: the first limit of it that is tried [assumed]
    smallest_share: float = 2e-3  # of its largest value: the least that is tried of what starts from nothing [assumed]


@dataclass(frozen=True)
class SpectrumThresholds:
    """Spectra of the scores of waves."""

    bins: int = 1 << 16  # 1: of positions or times, at least: the shortest period is some bins long [assumed]
    peaks_exact: int = 5  # 1: of each view of a spectrum, that are looked at exactly [cost]
    peak_min: float = 2.0  # T: what is lower is no peak [assumed]
    probe_rows: int = 1 << 13  # rows: of an impulse response; at any rate the observer has settled by then [assumed]
    probe_start: int = 8  # 1: part of these rows before the impulse, as a divisor [assumed]
    reading_turns: float = 1.5  # turns in the travel: fewer of a reading's error are one of its scale [assumed]
    rounding_counts: float = 32.0  # counts: rounding at a steady speed repeats itself over fewer [assumed]
    followed_rate: float = 0.25  # of the sample rate: rows no longer follow a faster wave [assumed]
    beside_known: tuple[float, ...] = (-0.7, -0.35, 0.0, 0.35, 0.7)  # turns: more than a known wave [assumed]
    beside_peak: tuple[float, ...] = (-0.3, -0.15, 0.15, 0.3)  # turns: more than a peak, in its width [assumed]
    level_bins: int = 128  # 1: bins of a spectrum over which its level is taken [assumed]
    variance_min: float = 1e-7  # of the largest: a smaller variance of a score is not divided by [assumed]
    speed_edges: int = 41  # 1: edges of the speeds for which the variance is added up [assumed]


@dataclass(frozen=True)
class IntervalThresholds:
    """Intervals of time in which a force acts."""

    lengths_tried: int = 40  # 1: from the shortest to nearly the whole log [cost]
    shortest: float = 0.2  # s: what is shorter may be a single blow [assumed]
    longest: float = 0.9  # of the log: what is longer is no interval [assumed]
    intervals_exact: int = 8  # 1: that are looked at exactly [cost]
    widths_tried: int = 12  # 1: of a force at one place [cost]
    bins_of_width: int = 4  # 1: into which such a force is divided [cost]


@dataclass(frozen=True)
class ScanThresholds:
    """The scan, and how shapes are sharpened."""

    stands_out: float = -3.0  # ln p: from which a wave's period is tried by other effects too [assumed]
    hope: float = -6.0  # score: from which a sharper shape may yet make something of it [cost]
    sharpened_within: float = 60.0  # score: what is farther from the best is not sharpened [cost]
    peaks_refined: int = 4  # 1: peaks of a spectrum whose width is looked through [cost]
    rounds: int = 3  # 1: of moving one shape [cost]
    rounds_of_size: int = 6  # 1: the same where the shape alone makes the effect: it is also its size [cost]
    rounds_more: int = 4  # 1: for each further shape [cost]
    first_step: float = 0.35  # 1: logarithm of a shape's first step [assumed]
    step_shrinks: float = 0.4  # 1: factor on a step that no longer helps [assumed]
    wave_step: float = 0.2  # turns in the travel or the log: of a step of 1 [assumed]
    linear_step: float = 0.25  # of the range: of a step of 1 [assumed]
    below_range: float = 0.5  # of the lowest value: a logarithmic shape may go down to [assumed]
    outside_range: float = 0.01  # of its ends: shapes may pass them by [assumed]


@dataclass(frozen=True)
class FindingThresholds:
    """Findings judged."""

    faint_counts: float = 0.06  # counts: a smaller wave in the reading may be rounding's [0.03 on 281 blind nulls]
    findings_profiled: int = 8  # 1: the best, that are judged against the noise that they leave [cost]
    worth_profiling: float = 6.0  # T: from which that is worth the time [cost]
    size_linear: tuple[float, float] = (0.02, 50.0)  # 1: by what a finite column is scaled, from nothing [assumed]
    size_finite: tuple[float, float] = (0.25, 2.5)  # 1: the same of any other finite column [assumed]


@dataclass(frozen=True)
class MapErrorThresholds:
    """Errors of a cogging map."""

    error_size: float = 0.3  # of the amplitude: 1-sigma of the map; also of the ratio of sines to cosines [assumed]
    error_seen: float = -5.0  # ln p: from which an error of the map is seen [assumed]


# Residual -------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ShapeThresholds:
    """Forces of any shape in a coordinate."""

    travel_places: int = 9  # 1: places along the travel [assumed]
    time_places: int = 13  # 1: moments of a force, of friction and of gain [assumed]
    ageing_places: int = 7  # 1: moments of drag [assumed]
    value_places: int = 9  # 1: quantiles of command and acceleration [assumed]
    gain_speeds: int = 6  # 1: quantiles of speed, for the gain [assumed]
    way_speeds: int = 7  # 1: quantiles of speed in one direction [assumed]
    way_rows: int = 50  # rows in one direction: fewer have one place [assumed]
    pitch_places: int = 8  # 1: places in a pitch [assumed]
    plain_share: float = 0.15  # of the gap's power: what explains more unwhitened is tried against its noise [assumed]
    shape_promising: float = 6.0  # T above its freedom: from which a shape is judged against its own noise [cost]


@dataclass(frozen=True)
class EventThresholds:
    """What happens at moments."""

    events_max: int = 12  # 1: of one kind [assumed]
    jumps_suspected: float = -3.0  # ln p: from which jumps are held against blows of force [cost]
    jumps_apart: float = 0.02  # s: jumps that are closer are one [assumed]
    jump_counts: float = 2.0  # counts: a jump must have; rounding alone makes it one, now and then [assumed]
    blow_lengths: tuple[float, ...] = (0.002, 0.006, 0.02, 0.06)  # s: a force may be taken for a jump [assumed]
    friction_lengths: tuple[float, ...] = (0.05, 0.08, 0.13, 0.2, 0.32, 0.5, 0.8)  # s: of other friction [assumed]
    friction_level: float = 4.0  # times the mean squared score: an interval of friction must have [assumed]
    tail: float = 0.99  # quantile: of the squared scores, that of `chi_square_hundredth` [exact]


@dataclass(frozen=True)
class BurstThresholds:
    """Intervals in which the residual is louder."""

    band: tuple[float, float] = (8.0, 60.0)  # Hz: below, friction is re-tuned; above, a coarse encoder [assumed]
    burst_block: float = 0.1  # s: of one value of power [assumed]
    blocks_min: int = 20  # 1: in motion, of a log [assumed]
    block_moving: float = 0.5  # of its rows: in motion, more of a block [assumed]
    bursts_max: int = 12  # 1: blocks that a burst may be made of [assumed]
    blow_cut: float = 3.0  # rms: beyond it a single row is cut, for a blow is no burst [assumed]
    speed_levels: int = 4  # 1: ranges of speed with a level of noise each [assumed]
    speed_levels_of_rows: int = 24  # 1: the same where every row counts [assumed]
    jump_blocks: int = 3  # 1: blocks of 0.2 s over which a jump of the variance is taken [assumed]
    jump_rows: int = 100  # rows: in them, at least [assumed]


@dataclass(frozen=True)
class LookAlikeThresholds:
    """Waves that are like a named one, but go with something else."""

    wave_alike: float = 0.5  # cosine: less of what a look-alike and the finding explain is another effect [assumed]
    wave_peaks: int = 4  # 1: of each kind's spectrum [cost]
    wave_places: int = 8  # 1: places in a period, that are told [drawn]


@dataclass(frozen=True)
class LocationThresholds:
    """Where a gap sits, before a name."""

    told: float = -9.5  # ln p: a coordinate or wave below it is told [assumed]
    told_with_names: float = -7.0  # ln p: the same in the lines of a result [assumed]
    waves_max: int = 5  # 1: that are told [assumed]
    wave_turns_min: float = 4.0  # turns in the travel or the log: coordinates tell slower waves [assumed]
    wave_share_min: float = 0.1  # of the strongest wave's share: weaker ones are its shadows [assumed]
    waves_refined: int = 2  # 1: of each kind [cost]
    place_strong: float = 3.0  # deviations: from which a place is told [assumed]
    run_strong: float = 0.1  # of the strongest place: weaker runs are not told [assumed]
    runs_told: int = 2  # 1: runs of one sign [drawn]
    moments_told: int = 4  # 1: of what happened [drawn]
    speeds_apart: float = 1.1  # 1: ratio of two speeds that are told as a range [drawn]
    told_below: float = 0.1  # m or m/s: lengths and speeds are told in milli [drawn]
    micro_below: float = 1e-4  # m: lengths are told in micro [drawn]
    share_told: float = 0.01  # 1: a smaller share is told as under 1 % [drawn]


# Choose ---------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class SearchThresholds:
    """How far the search goes."""

    hinted: float = -3.0  # ln p: in one effect's scan, from which the confirm logs are asked [tuned]
    rival: float = 2.0 * float(np.log(100.0))  # score: a closer rival is an alternative; likelihood ratio 100 [tuned]
    rescan_from: float = 0.6  # of `detected` (ln p): from there filters are estimated without the best [assumed]
    rescan_within: float = 150.0  # score: what is farther from the best is not looked at again [tuned]
    map_rival: float = 2.0  # of `rival`: an error of the map within that speaks against a name [assumed]
    effects_max: int = 4  # 1: names that are added at most [tuned]
    terms_max: int = 8  # 1: terms of all names [tuned]
    harmonics_max: int = 3  # 1: terms of one name; a fourth would tell of its shape alone [tuned]


@dataclass(frozen=True)
class ChoiceThresholds:
    """Which finding stands out, and which of several alike is the one."""

    detected: float = -9.5  # ln p: in one effect's scan, of some 20; 0.15 % in all [tuned]
    possible: float = -1.5  # ln p: the same, from which a rival counts [tuned]
    near_best: float = -5.0  # ln p: the same for a rival of what stands by itself [tuned]
    joint: float = -15.0  # ln p: of both logs together, where `detected` is not reached [tuned]
    unshown: float = -20.0  # ln p: of what the confirm logs cannot show [tuned]
    slippery: float = -60.0  # ln p: the same of friction and intervals: odd friction near rest is like them [tuned]
    worth: float = 0.01  # of the residual's power below 60 Hz: what explains less is not worth a name [tuned]
    overwhelming: float = 1000.0  # score: beyond it effects are taken in the order of what they are worth [tuned]
    reach: float = 60.0  # score: what is farther from the best is no rival [tuned]
    form: float = 0.05  # of T: how well the form of anything is known [tuned]
    loss_max: float = 60.0  # of 2 ln likelihood: no confirm log speaks against a rival with more [assumed]
    like: float = 0.5  # cosine between what two findings explain: more are alike [tuned]
    same_period: float = 0.01  # 1: relative difference of periods that are one [tuned]
    mostly: float = 0.7  # of T: a plain wave stands for its modulation [tuned]
    nearly: float = 0.9  # of T: few amplitudes stand for many [tuned]
    many: int = 4  # 1: amplitudes, above which there are many [tuned]
    few: int = 2  # 1: amplitudes of a plain effect, at most [assumed]


@dataclass(frozen=True)
class ConfirmationThresholds:
    """What other motion says."""

    informative: float = 10.0  # lambda: from which the silence of the confirm logs counts [assumed]
    amplitude_error: float = 0.15  # 1: 1-sigma of the ratio at least, since amplitudes are estimates [assumed]
    less_refutes: float = 3.0  # deviations: less than expected by more refutes [assumed]
    more_refutes: float = 10.0  # deviations: the same for more than expected, maybe a shape not quite right [assumed]
    retuning_iterations: int = 4  # 1: of the fit on the confirm logs [cost]
    travel_points: int = 2000  # 1: along the travel, where coggings are compared [assumed]
    shifts: int = 97  # 1: of one cogging against another within a period [assumed]
    zero_shift: float = 1.0 / 12.0  # of the longest period: from which zeros of position differ [assumed]
    wave_turns: int = 48  # 1: phases at which a wave may come back [assumed]
    turn_penalty: float = 4.0  # of 2 ln likelihood: for a phase that is free [assumed]


@dataclass(frozen=True)
class FormThresholds:
    """Other laws of the same cause."""

    harmonics: tuple[int, ...] = (2, 3, 4, 5)  # 1: of a wave that is no sine [assumed]
    places: int = 11  # 1: along the travel, of friction and of an amplitude [assumed]
    end_places: tuple[float, ...] = (0.0, 0.03, 0.07, 0.13, 0.22)  # of the travel: from each end [assumed]
    around: float = 0.3  # of its length: how far a push may reach beyond its interval [assumed]
    widths: float = 2.5  # widths: how far a force at one place may reach to each side [assumed]
    pushes: int = 9  # 1: moments of a push, and of a gain [assumed]
    slow: float = 0.6  # of the largest speed: friction that goes with speed is free below [assumed]
    slow_speeds: int = 6  # 1: of friction, that are free [assumed]
    powers: tuple[float, ...] = (1.5, 3.0)  # 1: of the speed, beside the square [assumed]
    bends: tuple[float, ...] = (2.0, 3.0)  # 1: powers of the position of a spring [assumed]
    large_commands: tuple[float, ...] = (0.4, 0.6, 0.75, 0.9, 1.0)  # of the largest: where they may be cut [assumed]
    small_commands: tuple[float, ...] = (0.0, 0.7, 1.5, 3.0, 5.0)  # widths: where they may do less [assumed]
    width_max: float = 0.1  # of the largest command: of a dead zone, for these [assumed]
    lag_dampings: tuple[float, ...] = (0.5, 0.8, 1.2)  # 1: of a lag of second order [assumed]
    cost: float = 2.0  # of 2 ln likelihood: for each column of a form, as for an amplitude [assumed]
    contender: float = 25.0  # score: a finding whose free law comes so near to the best is a rival [assumed]
    left: float = 0.5  # of the score of what was left: more than that left over, and the law was not it [assumed]
    shaped_max: int = 2  # 1: effects of a result that have another shape [cost]


@dataclass(frozen=True)
class NearRestThresholds:
    """Friction near rest that is not the model's."""

    slow_shown: float = -20.0  # ln p: of shapes of slow friction, with confirm logs [assumed]
    slow_again: float = -12.0  # ln p: the same on the confirm logs [assumed]
    slow_alone: float = -40.0  # ln p: without confirm logs [assumed]
    rounded: float = 0.15  # of the residual's power: rounding that looks like friction near rest [tuned]
    creep_widths: float = 4.0  # widths of friction: creep up to there would tell the laws apart [assumed]
    creep: float = 0.3  # of the slowest speed that counts: where creep should begin [assumed]


# Refit and accept -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class RefitThresholds:
    """The fit of a model with an effect in it."""

    iterations: int = 8  # 1: of the joint fit, at most [cost]
    amplitude_excess: float = 1.01  # of the largest amplitude of an effect: one that runs beyond is refused [assumed]
    floor_of_range: float = 0.5  # of the lowest value that is looked for: shapes stay above [assumed]
    floor_of_high: float = 1e-4  # of the highest: the same where the lowest is nothing [assumed]
    ceiling_of_range: float = 2.0  # of the highest value that is looked for: shapes stay below [assumed]
    tuning_iterations: int = 3  # 1: of tuning nuisances to the gap [cost]
    tuning_halvings: int = 4  # 1: of a step that makes the gap larger [cost]
    tuning_gain: float = 5e-4  # of the gap: a smaller gain ends the tuning [cost]


@dataclass(frozen=True)
class AcceptanceThresholds:
    """Whether an effect pays, and the terms that must not."""

    power_growth: float = 0.02  # of the gap's power: it may grow by chance, but never by more [assumed]
    blocks: int = 20  # 1: of a log, between which gains differ by chance [assumed]
    position_growth: float = 1.1  # times the error of the replayed position: it may not become more [assumed]
    placebos_max: int = 5  # 1: placebo terms that are told [assumed]
    placebo_suspected: float = -6.0  # ln p: what is below and was refused is no placebo [assumed]
    placebo_like: float = 0.3  # cosine with another placebo: above, it would say the same again [assumed]


# Name and verdict -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class NameThresholds:
    """Alternatives of a name, and its confidence."""

    surest: float = 0.97  # 1: confidence of a name that nothing speaks against; as many are right [blind logs]
    least_sure: float = 0.01  # 1: confidence that no name is below [assumed]
    formless: float = 6.0  # score: by which any shape must explain more than an effect of the right form [assumed]
    unresolved_share: float = 0.5  # of T: a rival at a known period must explain, to be unresolved [assumed]
    refused_strong: float = -25.0  # ln p: of a refused effect that puts the names in doubt [assumed]
    turns_apart: float = 1.5  # turns in the travel: periods within that are not resolved [assumed]
    alike_margin: float = 25.0  # score: for a rival that explains nearly the same rows [assumed]
    nearly_same_rows: float = 0.85  # cosine: above, two findings explain nearly the same rows [assumed]
    weak: float = 35.0  # T: below it a name is a little less sure [assumed]
    ratio_doubted: float = 2.0  # deviations: of what other motion shows from what was expected [assumed]
    if_unconfirmed: float = 0.93  # factor on the confidence: without confirm logs [assumed]
    if_uninformed: float = 0.88  # factor: confirm logs that cannot show it [assumed]
    if_ratio_doubted: float = 0.8  # factor: see `ratio_doubted` [assumed]
    if_formless: float = 0.7  # factor: any shape explains more, see `formless` [assumed]
    if_shapes_left: float = 0.75  # factor: something is left that has no name [assumed]
    if_map: float = 0.8  # factor: an error of the map explains as much [assumed]
    if_weak: float = 0.9  # factor: see `weak` [assumed]
    if_other_shape: float = 0.95  # factor: its law is not the plainest [assumed]
    if_full_name: float = 0.5  # factor: a wave beside a name that has all the terms it may have [assumed]


@dataclass(frozen=True)
class ParameterChangeThresholds:
    """Mass and friction beyond what is stated; effects that vanish; ranges."""

    changed: float = 4.2  # deviations, stated and found together: beyond, mass or friction has changed [assumed]
    shared: float = 0.7  # of what a change does to the logs: an alternative does too [assumed]
    vanishing: float = 1e-3  # of the command: a force below is as good as none [assumed]
    change_clear: float = 5.0  # deviations: from which a change is sure [assumed]
    sure_of_change: float = 0.97  # 1: confidence of a change beyond that [assumed]
    less_sure_of_change: float = 0.86  # 1: confidence of a smaller one [assumed]
    if_shapes_left_too: float = 0.8  # factor: something is left that has no name [assumed]
    vanished: float = 0.25  # of its size: an effect of the model that falls below was masking another [assumed]
    range_tails: tuple[float, float] = (0.05, 0.95)  # quantiles of the force: the range that holds most [drawn]
    range_tighter: float = 0.02  # of the rows: by which another coordinate must hold it more tightly [drawn]
    dynamics_from: float = 10.0  # Hz: lower end of the range of a delay, lag or mode [drawn]


@dataclass(frozen=True)
class VerdictThresholds:
    """The verdict, and what no effect explains."""

    sure: float = 0.9  # 1: confidence from which a name is stated [assumed]
    doubted: float = 0.7  # 1: confidence below which a name falls to a better shape without a name [assumed]
    own_cause: float = 0.5  # of the strongest effect's T: a residual shape beyond has a cause of its own [assumed]
    left_over: float = -12.0  # ln p: of a generic shape; it also catches what friction laws differ by [tuned]
    again: float = -5.0  # ln p: of the same coordinate on the confirm logs [assumed]
    together: float = -26.0  # ln p: of both logs at once, where each is below `again` [assumed]
    jump: float = -18.0  # ln p: of readings that jump, on any log: no model's error does that [assumed]
    jumps_together: float = -12.0  # ln p: the same of both logs [assumed]
    interval: float = -12.0  # ln p: of intervals of friction: what laws differ by comes and goes too [assumed]
    intervals_together: float = -60.0  # ln p: the same of both logs [assumed]
    lonely: float = -100.0  # ln p: of a shape in time, which other motion need not show [assumed]
    variance: float = -80.0  # ln p: of a burst at any frequency; a coarse encoder's noise goes with speed [assumed]
    burst: float = -12.0  # ln p: of bursts of force: noise has its own [assumed]
    bursts_together: float = -60.0  # ln p: the same of both logs [assumed]
    rounding: float = 0.07  # of the residual's power: from there the encoder's rounding is no white noise [assumed]
    systematic: float = 0.1  # of the rms command: less of what a generic force predicts is small [assumed]
    weakened: float = 2.0  # 1: what is left must then have as many times the ln p [assumed]


# Gap and report -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class GapThresholds:
    """The gap, before and after."""

    jitter: float = 0.01  # of the sample time: more than a microsecond of resolution makes; no replay [assumed]
    jitter_quantile: float = 0.9  # quantile: of the steps' deviations, that is held against `jitter` [assumed]
    followed: float = 3.0  # floors of noise: a replay farther off measures something else [assumed]
    floor_rank: float = 1e-9  # of a column's size: ridge and rank of the fit that leaves the floor [assumed]
    closed_min: float = 1e-3  # of the squared gap: less above the floor is no share to close [assumed]
    smoothing: float = 0.02  # s: over which velocities are averaged for an acceleration [assumed]


@dataclass(frozen=True)
class PredictableThresholds:
    """The generic force that what is left is held against."""

    folds: int = 5  # 1: parts of the given logs, each in turn predicted by the others [assumed]
    fold_blocks: int = 20  # 1: blocks of a log in time, dealt to the folds in turn [assumed]
    ridges: tuple[int, int] = (-8, 5)  # half decades of a column's power: of the ridges that are tried [assumed]
    generic_bends: tuple[int, ...] = (41, 15, 13, 13)  # 1: of a force of place, speed, acceleration, command [assumed]
    lags: tuple[int, ...] = tuple(2**k for k in range(9))  # rows: by which the drive is moved, for a memory [assumed]
    column_least: float = 1e-9  # of the largest column: what one that is zero everywhere counts as [exact]


@dataclass(frozen=True)
class ReportThresholds:
    """What figures and pages show."""

    band_block: float = 0.25  # s: closer rows say much the same: bands are computed from blocks [assumed]
    trace_window: float = 0.01  # s: over which traces are averaged [drawn]
    trace_points: int = 4000  # 1: of a trace; more cannot be seen [drawn]
    bin_edges: int = 41  # 1: of bins of equal width in position and time [drawn]
    bin_quantiles: int = 33  # 1: of bins elsewhere, and of a folded period [drawn]
    bin_edges_even: int = 17  # 1: edges of equal width beside these quantiles [drawn]
    bin_width_min: float = 1e-2  # of the whole range: no bin is narrower [drawn]
    bin_rows: int = 20  # rows: the mean of fewer is noise [assumed]
    profile_rows: int = 100  # rows: fewer are no such motion [assumed]
    liveliest_share: float = 0.95  # of the most motion in a stretch: as good as that [drawn]
    deviation_shown: float = 4.0  # median deviations: larger bars are cut [drawn]
    folded_milli: float = 0.1  # m: shorter periods are drawn in mm [drawn]
    shapes_drawn: int = 6  # 1: coordinates on a page, at most [drawn]
    periods_drawn: int = 3  # 1: folded periods on a page, at most [drawn]
    names_in_headline: int = 2  # 1: effects that a headline names, at most [drawn]
    name_longest: int = 60  # 1: characters of a name in a headline; the middle of a longer one is left out [drawn]
    probable: float = 0.5  # 1: a name of this confidence is probable, of less it is perhaps [assumed]
    percent_least: float = 0.01  # 1: of shares that are told in whole percent [exact]
    all_of_it: float = 1.0  # 1: a share that leaves nothing [exact]
    share_hardly: float = 0.05  # 1: a smaller share of the gap is hardly any [assumed]
    chance_percent: float = 2.0  # decades: a likelier chance is told in logs of 100 [drawn]
    chance_never: float = 6.0  # decades: a rarer one is told as practically never [drawn]
    answer_lines: int = 13  # lines: of the printed answer, at most, without the files written and what is next [drawn]
    headline_lines: int = 2  # lines: of its headline, at most [drawn]
    remarks: int = 3  # lines: of what cannot be told apart, has no name or was planned, at most [drawn]
    answer_width: int = 100  # characters: of such a line [drawn]


# Large effects --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class AllowanceThresholds:
    """How far re-tuning may move mass and friction."""

    stated: float = 4.2  # stated deviations: beyond them a parameter has changed, as in PARAMETER_CHANGE [tuned]
    unstated: float = 3.0  # factor: either way, where nobody states how well a parameter is known [assumed]
    far: float = 1.5  # times an end: a parameter that re-tuning takes farther stands for something else [assumed]
    let_go: float = 30.0  # times an end of what is allowed: a parameter that is let go may be so far off [assumed]
    at_end: float = 1e-6  # 1: relative; so near to an end of what is allowed a parameter stands at it [exact]


@dataclass(frozen=True)
class BalanceThresholds:
    """The force balance in which large effects are looked for."""

    cutoffs: tuple[float, ...] = (0.1, 0.03, 0.018, 0.01, 0.006, 0.003)  # of the sample rate: filters tried [assumed]
    lowest_cutoff: float = 2.0  # Hz: no cut-off is lower [assumed]
    noise: float = 0.05  # of the rms command: what the encoder may make of it, else a lower cut-off [pendulum]
    rows_max: int = 30_000  # rows: of a log that are looked at; a lower cut-off needs fewer [cost]
    slow_rows: float = 0.02  # of the largest speed: slower rows show what friction does at rest [assumed]
    filter_reach: float = 0.5  # periods of the cut-off: so far the filter brings what friction does at rest [assumed]
    rows_left: float = 0.3  # of the rows in motion: fewer away from rest, and those near it count too [assumed]
    gain_min: float = 0.05  # 1: a gain of the command is taken to be at least, where a fit tries a smaller one [exact]
    turn_max: float = 1.5  # rad: half a turn of a resonance in a sample is less than a quarter turn [exact]
    column_size: float = 1e-12  # of the residual: a column that is smaller does nothing [exact]
    no_room: float = 1e-9  # of a column's size: between the ends of what does not move [exact]


@dataclass(frozen=True)
class SeedThresholds:
    """Terms that the force balance may lack."""

    turns: float = 1.5  # over the travel, or the time: a wave has at least, for a spring looks like less [assumed]
    fine: int = 4  # 1: wavenumbers of a spectrum for each that is independent [assumed]
    harmonic_max: float = 250.0  # turns over the travel: waves are sought up to there, the 200th of a turn [assumed]
    speeds: int = 40  # 1: classes of speed, in each of which the filter lets as much through [cost]
    spectrum_max: int = 1 << 20  # 1: lines of a spectrum at most [cost]
    interval_min: float = 0.02  # of a log: the shortest interval in which a force is sought [assumed]
    interval_lengths: int = 24  # 1: of such intervals [cost]
    peaks: int = 3  # 1: of a spectrum, that are looked at exactly [cost]
    looked_at: int = 3  # 1: seeds of a name, that are tried at their own size [cost]
    tried_together: int = 64  # 1: effects that are tried at once [cost]
    amplitude_room: float = 2.0  # times what an effect says: an amplitude that is no force may be so large [assumed]
    counts: float = 3.0  # counts of the encoder: an error of its reading has at least; rounding makes less [assumed]
    finite: tuple[float, ...] = (0.25, 4.0)  # times the size tried: of an effect that its shape makes [assumed]
    damping_ratios: tuple[float, ...] = (0.01, 0.05, 0.2)  # 1: of a load that hangs on the motor [assumed]
    mode_frequencies: int = 60  # 1: frequencies of its resonance [cost]
    sharpened: int = 3  # 1: of these, the best, that are looked at more closely [cost]
    mode_evaluations: int = 60  # 1: of the residual, while one is [cost]
    load_max: float = 0.95  # of the moving mass: that hangs on the motor [assumed]


@dataclass(frozen=True)
class LargeThresholds:
    """Which large effects are added, and when the search for small ones takes over."""

    large: float = 0.2  # of the rms command: what a model leaves unexplained is large from here [assumed]
    least: float = 0.04  # of the rms command: less is small even where nuisances went far to explain it [assumed]
    large_still: float = 0.02  # of the rms command: down to there further terms are sought after one [assumed]
    above_noise: float = 2.0  # times what the encoder makes of the balance: the same [assumed]
    power_taken: float = 0.15  # of the power that is left: a large effect takes away at least [assumed]
    parameter: float = 0.03  # of the ln of the power left: each parameter must be worth [assumed]
    near: float = 0.7  # of the ln of the power taken: seeds that take so much are refitted too [assumed]
    starts: int = 4  # 1: first terms from which the search starts, while what is left stays large [cost]
    near_start: float = 0.5  # of the ln of the power left: first terms so near to the best are followed too [assumed]
    rivals: int = 4  # 1: seeds that are refitted [cost]
    alternative: float = 0.15  # of the ln of the power left: a rival that leaves less than so much more [assumed]
    terms: int = 10  # 1: that are added at most [cost]
    growth: float = 1.01  # times the gap on other motion: no term makes it larger [assumed]
    refit_evaluations: int = 12  # 1: of the residual and its derivatives in a refit, at most [cost]
    tolerance: float = 1e-5  # of the power left: a refit ends there [cost]
    inside: float = 1e-6  # of the room of a parameter: where a refit starts from one of its ends [exact]
    timing_gain: float = 30.0  # 2 ln likelihood: an effect of timing must gain on whitened residuals [assumed]
    whitened_iterations: int = 8  # 1: of the fit of whitened residuals that follows [cost]
    trials: float = 1000.0  # 1: shapes that were looked at, of all effects [assumed]
    shape_doubt: float = 0.15  # of the first gap: what is found in less may be the shape of a larger one [assumed]
    half_explained: float = 0.5  # of the power: a term that leaves more is not what the gap is most of [assumed]
    settled: float = 0.2  # of the gap before: with more left, and above noise, no large name is sure [tuned]
    settled_noise: float = 1.4  # times the floor: what is left above that is more than noise [tuned]
    unexplained: float = 0.1  # of the power of a large gap: with less left, what is left does not name it [assumed]
    map_harmonics: int = 3  # 1: waves that are one map of the cogging, at least [assumed]
    pitch_max: int = 12  # 1: turns of the longest period in a pitch, at most [assumed]
    pitch_within: float = 0.004  # 1: relative; so near to a whole part of the pitch its periods are [assumed]
    shown: float = 0.03  # of the gap on other motion: it shows a term that takes more [assumed]


# Detection limits -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ChanceThresholds:
    """The chance that a search accepts an effect: the values over which it is averaged, and where it is computed."""

    noise_values: int = 21  # 1: equally likely values of a normal variable [cost]
    level_values: int = 4  # 1: the same, of the level of the noise [cost]
    other_chances: tuple[float, ...] = (0.2, 0.7)  # 1: equally likely ones of the other degrees of freedom [cost]
    statistics: tuple[float, float, int] = (1.0, 1e5, 120)  # T: first, last and number of those looked up [cost]
    lambdas: tuple[float, float, int] = (2.0, 2e3, 28)  # lambda: the same, at which the chance is computed [cost]
    level_firm: float = 0.05  # 1: spread of ln T, below which it is as good as none [assumed]
    ratio_gains: float = 0.5  # 1: ratio from which other motion fits better with the effect than without [exact]


@dataclass(frozen=True)
class LimitThresholds:
    """Detection limits, and the shapes of which they are told."""

    chance_shown: float = 0.95  # 1: with which an effect of the size of its limit would have been shown [assumed]
    chance_quantile: float = 1.645  # deviations: more than those below, a normal variable is so often [exact]
    normal_tail: float = 6.0  # deviations: beyond them a normal variable is as good as never [exact]
    size_step: float = 0.02  # of ln size: in which the limit is looked for [cost]
    size_depth: float = 16.0  # of ln size: how far below the largest it is looked for [assumed]
    change_factor: float = 2.0  # 1: relative change of a parameter, beyond which a machine is another [assumed]
    middle: tuple[float, float] = (0.25, 0.75)  # of a range: between which a shape is expected [assumed]
    middle_values: int = 3  # 1: that have a middle, at least [exact]
    likely_waves: int = 8  # 1: periods, or frequencies, of a wave [cost]
    likely_count: int = 12  # 1: shapes of an effect, at most [cost]
    phases: int = 4  # 1: of a wave, over half a turn: the sign makes no difference [cost]
    list_draws: int = 12  # 1: of amplitudes that are a list along the travel [cost]
    share_behind: float = 0.2  # of the mass behind a contact: for which a play is told [assumed]
    growth_groups: int = 12  # 1: shapes of an effect that has its size in the shape, at most [cost]
    unseen: float = -50.0  # ln lambda: of what these logs do not see [exact]
    typical: float = 50.0  # lambda: of an effect of about the size of its limit [assumed]


# The next experiment --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class MotionThresholds:
    """What a planned motion keeps to."""

    reference_share: float = 0.9  # of each limit: that a reference takes; its machine does a little more [assumed]
    travel_margin: float = 0.02  # of the travel: kept from each end [assumed]
    reference_rate: float = 2000.0  # Hz: of a reference's samples at most, for it is cubic between them [assumed]
    first_rest: float = 0.1  # s: before the first move [assumed]
    rest_between: float = 0.03  # s: after a move [assumed]
    move_min: float = 1e-9  # of the travel: what is shorter is no move [exact]
    ride_rows: int = 10  # rows: fewer are no swing [assumed]
    creep_left: float = 0.05  # s: with less left, creep ends [assumed]
    creep_back: int = 3  # 1: every so many moves of creep one goes back [assumed]
    creep_turn: int = 12  # 1: after so many moves creep changes its direction [assumed]
    swings_left: float = 0.5  # s: with less left, swings end [assumed]
    jerk_rise: float = 0.01  # s: in which the acceleration may rise to its limit where no jerk is stated [assumed]
    duration_min: float = 2.0  # s: of a motion; in less no row is left between its turns [assumed]
    duration_max: float = 600.0  # s: of a motion [cost]
    lasting: float = 0.02  # s: an acceleration is averaged over; held commands and noise make it jump [assumed]


@dataclass(frozen=True)
class ProposalThresholds:
    """The search for a motion."""

    parts: int = 3  # 1: motions one after another in a plan [assumed]
    part_min: float = 2.0  # s: of each of these motions, at least [assumed]
    slower: tuple[float, ...] = (1.0, 0.7, 0.5, 0.35, 0.2)  # 1: of speed and acceleration, until limits hold [assumed]
    exchange_passes: int = 4  # 1: of the exchange [cost]
    whole_motions: int = 4  # 1: combinations that are simulated as a whole [cost]
    refinements: int = 12  # 1: evaluations of the refinement [cost]
    refinement_step: float = 0.35  # of the logarithm of a parameter: at which it begins [assumed]
    speed_range: tuple[float, float] = (0.002, 1.0)  # of the limit: between which a refinement moves it [assumed]
    reach_range: tuple[float, float] = (0.02, 1.0)  # of the travel: the same [assumed]
    step_range: tuple[float, float] = (2e-4, 0.3)  # of the travel: the same [assumed]
    acceleration_range: tuple[float, float] = (0.05, 1.0)  # of the limit: the same [assumed]
    low_range: tuple[float, float] = (0.3, 60.0)  # Hz: the same, of the lower end of a band [assumed]
    high_range: tuple[float, float] = (1.0, 400.0)  # Hz: the same, of its upper end [assumed]
    slowest_range: tuple[float, float] = (0.02, 0.9)  # of the limit: the same, of random moves' least speed [assumed]


@dataclass(frozen=True)
class ExperimentThresholds:
    """What a motion is to answer, what is expected of it, and what came of that."""

    told_apart: float = 5.0  # deviations: from which diagnose takes a rival for no alternative [assumed]
    enough_apart: float = 3.0  # of `told_apart`: beyond it more is worth hardly anything [assumed]
    tells_nothing: float = 1.0  # deviations: below them a motion tells nothing of rivals [assumed]
    shapes_near: tuple[float, ...] = (0.7, 0.85, 1.18, 1.4)  # times a size: at which a shape is tried too [assumed]
    shape_beside: float = 1.2  # times: so far from a shape its effect is taken as in proportion to it [assumed]
    window_late: float = 0.8  # of a motion: a disturbance that begins later would not come in it [assumed]
    window_moved: tuple[float, float] = (0.3, 0.7)  # of a motion: between which it then acts [assumed]
    turns_tried: tuple[float, ...] = (0.7, 1.0, 1.5, 2.0, 3.0, 5.0, 8.0, 13.0, 21.0)  # turns: of a wave [cost]
    cycles_tried: tuple[float, ...] = (1.0, 3.0, 10.0, 30.0, 100.0)  # 1: of a tone in the motion [cost]
    column_singular: float = 1e-6  # of unit columns: what is nearer to each other is one column [assumed]
    trials_typical: float = 20.0  # 1: independent shapes of an effect, among which it must stand out [assumed]
    signal_none: float = 1e-9  # lambda: of a unit, from which down an effect cannot be seen [exact]
    size_beyond: float = 50.0  # times a shape's size: from there a limit is none [assumed]
    interval_rows: float = 1e6  # rows: with which an interval of 95 % is that of a normal variable [exact]
    vague: float = 10.0  # deviations of a parameter, in its own size: nothing is known of it [assumed]
    determined: float = 0.5  # of what was known: a narrower interval is told [assumed]
    came_short: float = 2.0 / 3.0  # of an expected distance: must be there; sizes are known no better [assumed]
    distance_scatter: float = 1.0  # deviations: by which a distance may be short besides [exact]
    came_wider: float = 2.0  # times: a limit or interval wider than expected by more did not come true [assumed]
    spline_order: int = 3  # 1: of an amplitude along the travel, as diagnose looks for it [exact]
    quiet_force: float = 0.01  # of the force of the acceleration: noise where a model states none [assumed]
    loudness_max: float = 10.0  # times: a measured floor farther off the model's noise is something else [assumed]
    tracking_pole: float = 60.0  # 1/s: of the loop that tracks where a model states none [assumed]
    tracking_rate: float = 1000.0  # Hz: of that loop [assumed]


DISTRIBUTION = DistributionConstants()
PREPARATION = PreparationThresholds()
PHYSICAL = PhysicalThresholds()
OBSERVER = ObserverThresholds()
NULL = NullThresholds()
WHITENING = WhiteningThresholds()
SCORE_TEST = ScoreTestThresholds()
GRID = GridThresholds()
SPECTRUM = SpectrumThresholds()
INTERVAL = IntervalThresholds()
SCAN = ScanThresholds()
FINDING = FindingThresholds()
MAP_ERROR = MapErrorThresholds()
SHAPE = ShapeThresholds()
EVENT = EventThresholds()
BURST = BurstThresholds()
LOOK_ALIKE = LookAlikeThresholds()
LOCATION = LocationThresholds()
SEARCH = SearchThresholds()
CHOICE = ChoiceThresholds()
CONFIRMATION = ConfirmationThresholds()
FORM = FormThresholds()
NEAR_REST = NearRestThresholds()
REFIT = RefitThresholds()
ACCEPTANCE = AcceptanceThresholds()
NAME = NameThresholds()
PARAMETER_CHANGE = ParameterChangeThresholds()
VERDICT = VerdictThresholds()
GAP = GapThresholds()
PREDICTABLE = PredictableThresholds()
REPORT = ReportThresholds()
ALLOWANCE = AllowanceThresholds()
BALANCE = BalanceThresholds()
SEED = SeedThresholds()
LARGE = LargeThresholds()
CHANCE = ChanceThresholds()
LIMIT = LimitThresholds()
MOTION = MotionThresholds()
PROPOSAL = ProposalThresholds()
EXPERIMENT = ExperimentThresholds()
