"""What scipy makes of a MATLAB file: a line for each variable, numbers as the bytes they are made of."""

import sys

import scipy.io

for name, value in scipy.io.loadmat(sys.argv[1]).items():
    if name.startswith("__"):
        continue
    if value.dtype.kind == "U":
        print("text", name, "".join(value))
    else:
        print("column", name, *value.shape, value.astype("<f8").tobytes("F").hex())
