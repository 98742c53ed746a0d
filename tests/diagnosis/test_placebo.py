"""Placebo terms."""


def test_placebo_terms_do_not_help(found):
    assert found.placebo
    assert not {p.name for p in found.placebo} & {e.name for e in found.effects}
    assert all(p.confirm_gain < 4.0 for p in found.placebo)  # a frozen term of no effect: -T on average
    assert "Placebo terms" in found.html()
