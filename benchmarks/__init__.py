"""What is timed, against what, and how: `make bench` puts the medians into records/benchmarks.json, which chapter 7 charts.

A module `rivals_*` for each quantity, collected in `rivals`; programs of others, which run as processes of their own, in
`yardsticks`. `method` says what a method is, `bench` times them, `record` reads the record.
"""
