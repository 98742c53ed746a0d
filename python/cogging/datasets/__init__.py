"""Public data of machines that other people measured: `emps`, `laas`, `odrive` and `tro2021`, each read from a folder.

Nothing is shipped here. `folder` of each function names where the files lie: the folder of the set itself, or one that
has it under the set's name. Where it is not given, the environment variable COGGING_DATA names a folder with subfolders
`emps`, `laas`, `odrive` and `tro2021`. Who has no data is told where to get them, and under which licence.
"""
