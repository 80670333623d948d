# Targets without a file: every figure by its name, every drawn slide by its number.

for target, names in build.targets().items():

    rule:
        name:
            target
        input:
            build.drawings(names),


build.refuse_unknown(sys.argv[1:], [rule.name for rule in workflow.rules])
