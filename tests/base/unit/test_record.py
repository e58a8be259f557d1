"""`Record`: immutable values with fields, equality and pattern matching."""

from collections.abc import Callable

import pytest

from launcher.base.model.record import Record, replace


class Point(Record):
    x: int
    y: int = 7


def test_fields_are_given_by_position_or_by_name_and_have_defaults():
    assert (Point(1).x, Point(1).y) == (1, 7)
    assert Point(1, 2) == Point(y=2, x=1)


def test_equal_values_are_equal_and_hash_alike_but_classes_differ():
    class Other(Record):
        x: int
        y: int = 7

    assert Point(1) == Point(1, 7)
    assert hash(Point(1)) == hash(Point(1, 7))
    assert Point(1) != Other(1)
    assert Point(1) != (1, 7)


@pytest.mark.parametrize("change", [lambda p: setattr(p, "x", 2), lambda p: delattr(p, "x")])
def test_a_record_cannot_be_changed(change):
    with pytest.raises(AttributeError, match="frozen"):
        change(Point(1))


@pytest.mark.parametrize(
    "make",
    [lambda: Point(), lambda: Point(1, 2, 3), lambda: Point(1, x=1), lambda: Point(1, z=3)],
    ids=["missing", "too many", "twice", "unknown"],
)
def test_wrong_fields_are_refused(make):
    with pytest.raises(TypeError):
        make()


def test_a_changed_copy_keeps_the_rest():
    assert replace(Point(1, 2), x=5) == Point(5, 2)


def test_it_matches_by_position_and_prints_its_fields():
    match Point(1, 2):
        case Point(x, y):
            assert (x, y) == (1, 2)
    assert repr(Point(1)) == "Point(x=1, y=7)"


class Rule(Record):
    name: str
    applies: Callable[[int], bool] = lambda number: number > 0


def test_a_default_that_is_a_function_is_called_as_one_that_is_given():
    assert Rule("default").applies(1)
    assert not Rule("given", lambda number: number < 0).applies(1)
