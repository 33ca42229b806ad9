"""The vectors of an exported controller, read from its test_vectors.c."""

import re
import struct


def bits(values):
    return [struct.pack("<d", value) for value in values]


def read(text):
    text = text.strip()
    return float(text.lower().replace("infinity", "inf")) if text[-1] in "YN" else float.fromhex(text)


def parsed(path):
    """Settings as (numbers, law); ticks as (settings, reset, fault, inputs, answers)."""
    text = re.sub(r"/\*.*?\*/", "", open(path).read(), flags=re.S)
    first, second = text.split("_vectors[", 1)
    laws = {"NONE": 0, "SWITCHED": 1, "INVERSE": 2}
    found = []
    for block in re.findall(r"\n    \{\n(.*?)\n    \},", first.split("= {", 1)[1], flags=re.S):
        words = [word for word in re.split(r"[\s,{}]+", block) if word]
        found.append(([read(word) for word in words if "LAW" not in word], laws[words[8].rsplit("_", 1)[1]]))
    ticks = []
    for head, inputs, answers in re.findall(r"\{(\d+, \d+, \d+), \{(.*?)\},\s*\{(.*?)\}\}", second, flags=re.S):
        row = [[read(word) for word in part.split(",")] for part in (inputs, answers)]
        ticks.append((*map(int, head.split(",")), *row))
    return found, ticks
