import numpy as np

from rfcompass.rf.runs import legs, runs


def test_one_port_and_one_antenna_make_one_run(make_trace):
    trace = make_trace([0.5, 0.7, 0.0])
    assert [rows.tolist() for rows in runs(trace)] == [list(range(51))]
    assert legs(trace) == 2.0


def test_ports_that_take_turns_are_told_apart(make_trace, line):
    ports = np.tile([1, 2], 26)[:51]
    found = runs(make_trace([0.5, 0.7, 0.0], line(), ports=ports))
    assert [ports[rows].tolist() for rows in found] == [[1] * 26, [2] * 25]


def test_transmitters_that_stand_still_are_told_apart(make_trace, line):
    tx_m = np.tile([[0.0, -1.0, 0.0], [1.0, -1.0, 0.0]], (26, 1))[:51]
    trace = make_trace([0.5, 0.7, 0.0], line(), tx_m=tx_m)
    assert [np.unique(tx_m[rows], axis=0).shape[0] for rows in runs(trace)] == [1, 1]
    assert legs(trace) == 1.0


def test_a_transmitter_that_moves_along_stays_in_one_run(make_trace, line):
    trace = make_trace([0.5, 0.7, 0.0], line(), tx_m=line() + np.array([0.0, 0.1, 0.0]))
    assert len(runs(trace)) == 1
    assert legs(trace) == 2.0


def test_a_wrist_that_goes_its_way_twice_stays_in_one_run(make_trace, line):
    twice_m = np.concatenate([line(), line()[::-1]])
    trace = make_trace([0.5, 0.7, 0.0], twice_m, tx_m=twice_m + np.array([0.0, 0.1, 0.0]))
    assert len(runs(trace)) == 1
    assert legs(trace) == 2.0


def test_transmitters_that_stand_still_are_told_apart_also_when_the_way_is_gone_twice(make_trace, line):
    twice_m = np.concatenate([line(), line()[::-1]])
    tx_m = np.tile([[0.0, -1.0, 0.0], [1.0, -1.0, 0.0]], (len(twice_m) // 2, 1))
    trace = make_trace([0.5, 0.7, 0.0], twice_m, tx_m=tx_m)
    assert len(runs(trace)) == 2
    assert legs(trace) == 1.0


def test_runs_hold_every_position_once(make_trace, line):
    rng = np.random.default_rng(3)
    trace = make_trace([0.5, 0.7, 0.0], line(), ports=rng.integers(1, 5, 51))
    assert sorted(np.concatenate(runs(trace)).tolist()) == list(range(51))
