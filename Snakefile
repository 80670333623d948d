"""The report, from statements to pages.

    statement -> check -> ledger -> gate ---------------\
                 data  -> figure -----------------------> report
                          statements, data -> chapter ---/

snakemake                everything             snakemake masking     the figure of that name
snakemake -n             what is to be done     snakemake slide_39    the figures of that slide
"""

import os
import sys
from pathlib import Path

sys.path.insert(0, "workflow")
sys.path.insert(1, "lib")

import build  # noqa: E402
import campaign  # noqa: E402
import closure  # noqa: E402
import guard  # noqa: E402
import inventory  # noqa: E402

build.settle_environment()
BUILDING = workflow.is_main_process and guard.begin(sys.argv[1:])

FIGURES = inventory.figures()
CHAPTERS = inventory.chapters()


wildcard_constraints:
    group=r"[\w.]+",
    name=r"\w+",
    form=r"pdf|html",
    chapter=r"\w+",


localrules:
    all,


rule all:
    input:
        "build/report.pdf",
        "build/report.html",
        expand("build/figures/{name}.svg", name=FIGURES),
    message:
        "done     build/report.pdf, build/report.html, build/figures"


rule check:
    output:
        "build/checks/{group}.json",
    priority: 1  # a long job that comes last leaves a processor idle
    params:
        statements=lambda wildcards: build.group(wildcards.group),
        number=lambda wildcards: len(build.group(wildcards.group)),
        fingerprints=lambda wildcards: build.fingerprints(wildcards.group),
    log:
        "build/logs/check/{group}.log",
    message:
        "check    {wildcards.group}: {params.number} statements"
    conda:
        "environment.yml"
    shell:
        "python -m microfacet check {params.statements} --kept build/kept --out {output} 2> {log}"
        " && python workflow/seal.py {output} 2>> {log} || python workflow/failed.py {log} $?"


rule checked:
    input:
        checks=expand("build/checks/{group}.json", group=build.groups()),
        tools=build.tools("ledger.py"),
    output:
        "build/checked",
    priority: 1  # a statement that fails is named within the first minute or two
    params:
        statements=build.digest(inventory.statements()),
    log:
        "build/logs/checked.log",
    message:
        "checked  no statement failed"
    conda:
        "environment.yml"
    shell:
        "python workflow/ledger.py checked build/checks {output} build/report.pdf build/report.html 2> {log}"
        " && python workflow/seal.py {output} 2>> {log} || python workflow/failed.py {log} $?"


rule measured:
    input:
        script=build.SIGNIFICANCE_TESTS,
        imports=build.imports(build.SIGNIFICANCE_TESTS),
        measured=campaign.gathered(build.SIGNIFICANCE_TESTS),
    output:
        "build/measured.json",
    log:
        "build/logs/measured.log",
    message:
        "measure  statements on surfaces and samples"
    conda:
        "environment.yml"
    shell:
        "python -m report.significance_tests {output} 2> {log}"
        " && python workflow/seal.py {output} 2>> {log} || python workflow/failed.py {log} $?"


rule ledger:
    input:
        "build/checked",
        checks=expand("build/checks/{group}.json", group=build.groups()),
        measured="build/measured.json",
        tools=build.tools("ledger.py"),
    output:
        report("build/ledger.json", category="Checks"),
    params:
        statements=build.digest(inventory.statements()),
    log:
        "build/logs/ledger.log",
    message:
        "ledger   {output}"
    conda:
        "environment.yml"
    shell:
        "python workflow/ledger.py gather build/checks {input.measured} {output} 2> {log}"
        " && python workflow/seal.py {output} 2>> {log} || python workflow/failed.py {log} $?"


rule gate:
    input:
        ledger="build/ledger.json",
        record=lambda wildcards: inventory.source("records/ledger.json"),
        tools=build.tools("ledger.py"),
    output:
        "build/gate",
    params:
        record=lambda wildcards: build.digest_of("records/ledger.json"),
    log:
        "build/logs/gate.log",
    message:
        "gate     no statement failed or got worse"
    conda:
        "environment.yml"
    shell:
        "python workflow/ledger.py gate {input.ledger} {input.record} {output} build/report.pdf build/report.html 2> {log}"
        " && python workflow/seal.py {output} 2>> {log} || python workflow/failed.py {log} $?"


rule data:
    input:
        script=lambda wildcards: build.figure(wildcards.name).data_script,
        imports=lambda wildcards: build.imports(build.figure(wildcards.name).data_script),
        measured=lambda wildcards: campaign.gathered(build.figure(wildcards.name).data_script),
    output:
        "build/data/{name}.npz",
    log:
        "build/logs/data/{name}.log",
    message:
        "data     {wildcards.name}"
    conda:
        "environment.yml"
    shell:
        "python {input.script} {output} 2> {log}"
        " && python workflow/seal.py {output} 2>> {log} || python workflow/failed.py {log} $?"


rule figure:
    input:
        script=lambda wildcards: build.figure(wildcards.name).script,
        data=lambda wildcards: build.figure(wildcards.name).data,
        imports=lambda wildcards: build.imports(build.figure(wildcards.name).script),
        style=inventory.source("figures/report.mplstyle"),
    output:
        report(
            "build/figures/{name}.svg",
            category="Figures",
            caption="workflow/figure.rst",
            labels={"figure": "{name}"},
        ),
        "build/figures/{name}.pdf",
        "build/figures/{name}.png",
    params:
        caption=lambda wildcards: build.figure(wildcards.name).printed_text,
    log:
        "build/logs/figure/{name}.log",
    message:
        "figure   {wildcards.name}"
    conda:
        "environment.yml"
    shell:
        "python {input.script} {input.data} {output} 2> {log}"
        " && python workflow/seal.py {output} 2>> {log} || python workflow/failed.py {log} $?"


rule motion:
    input:
        script=lambda wildcards: build.figure(wildcards.name).script,
        data=lambda wildcards: build.figure(wildcards.name).data,
        imports=lambda wildcards: build.imports(build.figure(wildcards.name).script),
        style=inventory.source("figures/report.mplstyle"),
    output:
        "build/figures/{name}.moving.svg",
    log:
        "build/logs/motion/{name}.log",
    message:
        "motion   {wildcards.name}"
    conda:
        "environment.yml"
    shell:
        "python {input.script} {input.data} {output} 2> {log}"
        " && python workflow/seal.py {output} 2>> {log} || python workflow/failed.py {log} $?"


rule chapter:
    input:
        text="chapters/{chapter}.md",
        data=lambda wildcards: build.chapter_data(wildcards.chapter),
        imports=lambda wildcards: build.chapter_imports(wildcards.chapter),
        tools=[*build.tools("chapter.py", "cells.py"), "workflow/filter.lua"],
    output:
        markdown="build/chapters/{chapter}.md",
        typst="build/chapters/{chapter}.typ",
    params:
        named=lambda wildcards: build.chapter_names(wildcards.chapter),
    log:
        "build/logs/chapter/{chapter}.log",
    message:
        "chapter  {wildcards.chapter}"
    conda:
        "environment.yml"
    shell:
        "python workflow/chapter.py {input.text} {output.markdown} {output.typst} 2> {log}"
        " && python workflow/seal.py {output} 2>> {log} || python workflow/failed.py {log} $?"


rule report:
    input:
        "build/gate",
        "build/ledger.json",
        chapters=expand("build/chapters/{chapter}.typ", chapter=build.texts()),
        figures=expand("build/figures/{name}.svg", name=build.figures_in_chapters()),
        moving=lambda wildcards: build.moving_in_chapters() if wildcards.form == "html" else [],
        works=inventory.source("chapters/references.bib"),
        title=inventory.source("CITATION.cff"),
        tools=lambda wildcards: build.report_tools(wildcards.form),
    output:
        report("build/report.{form}", category="Report"),
    params:
        source=build.source_options(),
    log:
        "build/logs/report.{form}.log",
    message:
        "report   {output}"
    conda:
        "environment.yml"
    shell:
        "python workflow/typeset.py {output} {params.source} 2> {log}"
        " && python workflow/seal.py {output} 2>> {log} || python workflow/failed.py {log} $?"


include: "workflow/campaign.smk"
include: "workflow/targets.smk"

if workflow.is_main_process:
    guard.compare(build.products(), BUILDING)


onerror:
    inventory.withdraw()
    build.repeat_failures(log)
