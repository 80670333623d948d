# Gaussian surfaces, ray traced: scattered over ranges of surfaces, gathered in their order.
#
# snakemake --config surfaces=400              more surfaces; those that were measured already are kept
# snakemake --config surfaces=400 range=50     in larger portions; the numbers stay the same

SURFACES, RANGE = build.surfaces_asked_for(config)


wildcard_constraints:
    entry=r"\w+",
    first=r"\d+",
    last=r"\d+",


rule measure:
    input:
        script="workflow/campaign.py",
        imports=lambda wildcards: build.imports(Path("workflow/campaign.py")),
    output:
        "build/campaign/{entry}/{first}-{last}.npz",
    log:
        "build/logs/campaign/{entry}/{first}-{last}.log",
    message:
        "measure  {wildcards.entry}, surfaces {wildcards.first}-{wildcards.last}"
    conda:
        "../environment.yml"
    shell:
        "MICROFACET_THREADS={threads} python {input.script} measure {wildcards.entry} {wildcards.first} {wildcards.last}"
        " {output} 2> {log}"
        " && python workflow/seal.py {output} 2>> {log} || python workflow/failed.py {log} $?"


rule gather:
    input:
        script="workflow/campaign.py",
        shards=lambda wildcards: campaign.shards(wildcards.entry, SURFACES, RANGE),
    output:
        "build/campaign/{entry}.npz",
    log:
        "build/logs/campaign/{entry}.log",
    message:
        "gather   {wildcards.entry}, {SURFACES} surfaces"
    conda:
        "../environment.yml"
    shell:
        "python {input.script} gather {output} {input.shards} 2> {log}"
        " && python workflow/seal.py {output} 2>> {log} || python workflow/failed.py {log} $?"
