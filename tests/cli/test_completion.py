"""The TAB key: what `cogging completion` prints, tried in the shells themselves."""

import shutil
import subprocess
import sys

import pytest

from cogging.cli.completion import SHELLS
from cogging.cli.main import COMMANDS, main

ASK = """
source /dev/stdin
for line in "cogging " "cogging dia" "cogging experiment --goal " "cogging diagnose second.csv --model fi"; do
  read -ra COMP_WORDS <<< "$line"; [[ $line == *" " ]] && COMP_WORDS+=("")
  COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); COMPREPLY=()
  _shtab_cogging cogging "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD-1]}"
  printf '%s\\t' "${COMPREPLY[@]}"; echo
done
"""


@pytest.mark.skipif(sys.platform == "win32", reason="shells of POSIX")
@pytest.mark.parametrize("shell", SHELLS)
def test_every_shell_reads_its_script_and_bash_completes(shell, tmp_path, capsys):
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert all(command in script for command in COMMANDS)
    if shutil.which(shell):
        done = subprocess.run([shell, "-n"], input=script, capture_output=True, text=True)
        assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    if shell == "bash" and shutil.which("bash"):
        (tmp_path / "first run.csv").touch()
        done = subprocess.run(["bash", "-c", ASK], input=script, cwd=tmp_path, capture_output=True, text=True)
        offered = [{word.strip() for word in line.split("\t") if word.strip()} for line in done.stdout.splitlines()]
        assert offered[0] >= set(COMMANDS)
        assert offered[1:] == [{"diagnose"}, {"separate", "detect", "fit"}, {"first run.csv"}]
