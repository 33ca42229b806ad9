"""What is asserted of the page: each scenario by its name."""

ALL = {}


def scenario(act):
    """Takes a function of (program, browser) among them."""
    ALL[act.__name__] = act
    return act
