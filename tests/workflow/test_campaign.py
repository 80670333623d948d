"""The campaign's jobs: ranges, what a figure reads, and a killed build that goes on where it was."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import campaign
import numpy as np
import pytest
import yaml
from checkout import ROOT, Checkout
from report.campaign import CAMPAIGN

ENTRY = "gabor_07"


def test_ranges_cover_every_surface_once() -> None:
    assert campaign.ranges(10, 4) == [(0, 4), (4, 8), (8, 10)]
    assert campaign.shards("lobes_07", 5, 5) == ["build/campaign/lobes_07/0-5.npz"]


def test_figures_name_entries_that_exist() -> None:
    named = {entry for script in (ROOT / "figures").glob("*/*_data.py") for entry in campaign.entries(script)}
    assert named == set(CAMPAIGN)
    assert campaign.entries(None) == campaign.entries(ROOT / "figures/visibility/masking_data.py") == []


def test_an_unknown_entry_is_one_sentence(tmp_path: Path) -> None:
    command = [sys.executable, str(ROOT / "workflow/campaign.py"), "measure", "lobes_7", "0", "1", str(tmp_path / "a.npz")]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, env=os.environ | {"PYTHONPATH": str(ROOT / "lib")}
    )
    assert done.returncode == 1
    assert done.stderr.startswith("The campaign has no 'lobes_7'; it has lobes_04")
    assert done.stderr.count("\n") == 1


@pytest.mark.slow
def test_a_killed_campaign_loses_the_running_ranges_only(tmp_path: Path) -> None:
    checkout = Checkout(tmp_path / "campaign")
    shutil.rmtree(checkout.path("lib"))
    shutil.copytree(ROOT / "lib", checkout.path("lib"), ignore=shutil.ignore_patterns("__pycache__"))
    target, config = f"build/campaign/{ENTRY}.npz", ["--config", "surfaces=6", "range=1"]
    command = [sys.executable, "-m", "snakemake", "--cores", "1", target, *config]
    process = subprocess.Popen(command, cwd=checkout.root, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                               start_new_session=True)  # fmt: skip
    shards = checkout.path(f"build/campaign/{ENTRY}")
    while len(list(shards.glob("*.npz"))) < 2:
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    kept = {path: path.stat().st_mtime_ns for path in shards.glob("*.npz")}
    done = checkout.snakemake(target, *config)
    assert done.returncode == 0, done.stdout
    again = sum(kept[path] != path.stat().st_mtime_ns for path in kept)
    assert again <= 1
    assert len(re.findall(r"^Job \d+: measure", done.stdout, re.M)) == 6 - len(kept) + again
    few = dict(np.load(checkout.path(target)))
    assert checkout.snakemake(target, "--config", "surfaces=6", "range=4").returncode == 0
    for name, values in np.load(checkout.path(target)).items():
        np.testing.assert_array_equal(values, few[name])


def test_the_cluster_has_what_its_profile_asks_for() -> None:
    profile = yaml.safe_load((ROOT / "profiles/slurm/config.yaml").read_text("utf-8"))
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    assert any(one.startswith(f"snakemake-executor-plugin-{profile['executor']}") for one in extras["slurm"])
    assert profile["slurm-status-command"] == "squeue"  # with sacct, and no accounting, a failed job is never noticed
    assert (
        yaml.safe_load((ROOT / "profiles/default/config.yaml").read_text("utf-8")).items() - {("cores", "all")}
        <= profile.items()
    )


def test_a_job_of_a_cluster_asks_for_no_target() -> None:
    import build

    words = ["--target-jobs", "measure:entry=a", "--allowed-rules", "measure", "--cores", "1"]
    assert build.asked_for([word for word in words if word != "measure"]) == []
