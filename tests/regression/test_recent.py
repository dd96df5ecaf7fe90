"""What was made of the same objects is not made again."""

from pyident.regression.recent import Recent


def test_made_once_of_the_same_objects_and_key():
    recent, calls = Recent(2), []
    a, b = [1], [1]

    def of(thing, key):
        return recent.of((thing,), lambda: calls.append(key) or len(calls), key)

    assert [of(a, "x"), of(a, "x")] == [1, 1]
    assert of(b, "x") == 2, "equal, but another object"
    assert of(a, "y") == 3
    assert of(a, "x") == 4, "only two are kept"
