"""Regression by pairs: fixed episodes, driven anew and compared with `verify/baseline` to the bit.

drives      the fixed episodes, a set for each kind of task
outcomes    one drive as a few figures and a hash of its trajectory
policies    networks whose answers are on file, so that their drives are the same on every processor
baseline    the files, and what is wrong with them
comparison  which drives differ, how, and who got better or worse
"""
