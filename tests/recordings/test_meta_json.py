import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import TraceError
from rfcompass.recordings import SCHEMA, TraceMeta, TraceTag
from rfcompass.recordings.meta_json import is_trace_meta, meta_json, parse_meta

MINIMAL = {
    "schema": SCHEMA, "frame": "rail", "geometry": "monostatic", "phase_sign": 1, "phase_modulus": "2pi",
    "dimensions": 3, "tags": [{"epc": "A"}],
}  # fmt: skip

finite = st.floats(-1e6, 1e6)
vectors = st.tuples(finite, finite, finite)
words = st.text(min_size=1)
tags = st.builds(
    TraceTag, epc=words, body=st.just("leg"), link=st.none() | words, point_m=st.none() | vectors,
    dipole=st.none() | vectors.filter(any), unknown_json=st.just('{"colour": "red"}') | st.just("{}"),
)  # fmt: skip
metas = st.builds(
    TraceMeta, frame=words, geometry=st.sampled_from(["monostatic", "bistatic"]), phase_sign=st.sampled_from([1, -1]),
    phase_modulus=st.sampled_from(["pi", "2pi"]), dimensions=st.sampled_from([2, 3]),
    tags=st.lists(tags, max_size=4, unique_by=lambda tag: tag.epc).map(tuple), source=words, license=words,
    reader=words, robot=st.none() | words, tag_layout=st.none() | words,
    channel_offsets_rad=st.dictionaries(st.floats(1e-3, 1e12), finite).map(lambda d: tuple(d.items())),
    unknown_json=st.just('{"operator": {"name": "x"}}') | st.just("{}"),
)  # fmt: skip


@given(meta=metas)
def test_what_is_written_reads_back_equal(meta):
    assert parse_meta(meta_json(meta)) == meta


@given(meta=metas)
def test_equal_records_are_written_with_equal_bytes(meta):
    assert meta_json(parse_meta(meta_json(meta))) == meta_json(meta)


def test_unknown_keys_are_kept():
    content = {**MINIMAL, "operator": ["a", {"b": 1}], "tags": [{"epc": "A", "colour": "red"}]}
    rewritten = json.loads(meta_json(parse_meta(json.dumps(content))))
    assert rewritten["operator"] == ["a", {"b": 1}]
    assert rewritten["tags"] == [{"epc": "A", "colour": "red"}]


@pytest.mark.parametrize("key", [key for key in MINIMAL if key != "schema"])
def test_a_missing_key_is_named(key):
    with pytest.raises(TraceError) as caught:
        parse_meta(json.dumps({name: value for name, value in MINIMAL.items() if name != key}))
    assert caught.value.numbers["column"] == key


@pytest.mark.parametrize("schema", [None, "rfcompass-trace/2", 1, ["rfcompass-trace/1"]])
def test_another_schema_is_named(schema):
    with pytest.raises(TraceError) as caught:
        parse_meta(json.dumps({**MINIMAL, "schema": schema}))
    assert caught.value.numbers["schema"] == schema


@pytest.mark.parametrize("text", ["", "{", "[]", "3", '{"schema": NaN}', "[" * 100_000, '{"a": ' + "9" * 5000 + "}"])
def test_what_is_no_json_object_is_an_error_and_no_trace(text):
    with pytest.raises(TraceError):
        parse_meta(text)
    assert not is_trace_meta(text)


@pytest.mark.parametrize(
    ("column", "value"),
    [
        ("tags", {"epc": "A"}),
        ("tags", ["A"]),
        ("tags", [{"body": "leg"}]),
        ("epc", [{"epc": 3008}]),
        ("point_m", [{"epc": "A", "body": "leg", "point_m": [0, 1]}]),
        ("point_m", [{"epc": "A", "body": "leg", "point_m": [0, 1, "2"]}]),
        ("point_m", [{"epc": "A", "body": "leg", "point_m": [0, 1, True]}]),
        ("point_m", [{"epc": "A", "body": "leg", "point_m": [0, 1, 10**400]}]),
        ("dipole", [{"epc": "A", "body": "leg", "dipole": "z"}]),
    ],
)
def test_ill_typed_tags_are_an_error_that_names_the_key(column, value):
    with pytest.raises(TraceError) as caught:
        parse_meta(json.dumps({**MINIMAL, "tags": value}))
    assert caught.value.numbers["column"] == column


@pytest.mark.parametrize("offsets", [[0.1], {"x": 0.1}, {"920625000": "0.1"}, {"nan": 0.1}, {"-1": 0.1}])
def test_ill_typed_channel_offsets_are_an_error(offsets):
    with pytest.raises(TraceError) as caught:
        parse_meta(json.dumps({**MINIMAL, "channel_offsets_rad": offsets}))
    assert caught.value.numbers["column"] == "channel_offsets_rad"
