"""Scenarios of the scope page, one at a time:  scope_page.py SCENARIO PROGRAM SHOTS,  or  scope_page.py --list

Each one starts its own runs in the working directory, and its own browser. Screenshots go to the folder SHOTS.
"""

import sys

import scenario
import scope_links
import scope_looks
import scope_projects
import scope_runs
import scope_viewers
from browser import Browser
from running import Program

if sys.argv[1:] == ["--list"]:
    print("\n".join(sorted(scenario.ALL)))
else:
    name, program, shots = sys.argv[1:]
    program = Program(program, ".")
    try:
        with Browser(shots) as browser:
            scenario.ALL[name](program, browser)
    finally:
        program.end()
