"""The family "in the large": machines of any size whose model lacks what makes most of their command.

One to four effects make 30 to 95 % of the command's power, masses and friction of the model are wrong as far as it
says, half of the controllers are not stated, some logs are driven in open loop, and some are misread (sign, unit, time
base). `python -m tests.blind.large --seed N --cases K` draws cases and runs `cogging.diagnose` on them. Only `runner`
knows the package under test.
"""
