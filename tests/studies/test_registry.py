import pytest
import toy_registry

from rfcompass.errors import StudyError
from rfcompass.studies import registry


def test_every_registered_study_can_be_loaded():
    assert len(registry.all_studies()) == len(registry.STUDIES)


def test_a_study_is_found_by_its_name(monkeypatch):
    monkeypatch.setattr(registry, "STUDIES", ("toy_registry:FIRST", "toy_registry:SECOND"))
    assert list(registry.all_studies()) == ["first", "second"]
    assert registry.study("second") is toy_registry.SECOND


def test_an_unknown_study_lists_those_that_exist(monkeypatch):
    monkeypatch.setattr(registry, "STUDIES", ("toy_registry:FIRST", "toy_registry:SECOND"))
    with pytest.raises(StudyError, match="known: first, second") as caught:
        registry.study("third")
    assert caught.value.numbers["known"] == ["first", "second"]


def test_two_studies_of_one_name_are_refused(monkeypatch):
    monkeypatch.setattr(registry, "STUDIES", ("toy_registry:FIRST", "toy_registry:FIRST"))
    with pytest.raises(StudyError, match="two studies"):
        registry.all_studies()
