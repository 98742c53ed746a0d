"""Public measured data: `emps`, `laas`, `odrive` and `tro2021`, each read from a folder.

No data are shipped. `folder` of each function is the folder of the set, or one that contains it under the set's name;
by default the environment variable COGGING_DATA names a folder with `emps`, `laas`, `odrive` and `tro2021`. If files
are missing, the error says where to get them and under which licence.
"""
