"""What scipy makes of structures and cells in a MATLAB file: a line for each leaf, numbers as the bytes they are made of."""

import sys

import scipy.io


def walk(path, value):
    if value.dtype.names is not None:
        for name in value.dtype.names:
            walk(f"{path}.{name}", value[0, 0][name])
    elif value.dtype.kind == "O":
        for k, cell in enumerate(value.ravel(order="F")):
            walk(f"{path}{{{k + 1}}}", cell)
    elif value.dtype.kind == "U":
        print(path, "text", "".join(value.ravel()))
    elif value.dtype.kind == "c":
        parts = [part.astype(">f8").tobytes("F").hex() for part in (value.real, value.imag)]
        print(path, "complex", *value.shape, *parts)
    else:
        print(path, "real", *value.shape, value.astype(">f8").tobytes("F").hex())


for name, value in scipy.io.loadmat(sys.argv[1]).items():
    if not name.startswith("__"):
        walk(name, value)
