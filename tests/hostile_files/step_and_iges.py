"""Hostile files: STEP and IGES."""

from __future__ import annotations

from tests.hostile_files.families import family, filled


def step(rows: bytes) -> bytes:
    head = b"ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\n"
    head += b"FILE_NAME('','',(''),(''),'','','');\n"
    head += b"FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n"
    return head + rows + b"ENDSEC;\nEND-ISO-10303-21;\n"


@family("step points without end")
def _(size):
    row = b"#%d=CARTESIAN_POINT('',(0.,1.,2.));\n"
    return step(b"".join(row % k for k in range(1, max(2, size // 44))))


@family("step a chain of names")
def _(size):
    count = max(2, size // 40)
    row = b"#%d=ADVANCED_FACE('',(#%d),#%d,.T.);\n"
    return step(b"".join(row % (k, k + 1, k + 1) for k in range(1, count)))


@family("step a ring of names")
def _(size):
    rows = b"#1=CLOSED_SHELL('',(#2));\n#2=CLOSED_SHELL('',(#1));\n#3=MANIFOLD_SOLID_BREP('',#1);\n"
    return step(filled(rows, size))


@family("step nested deeply")
def _(size):
    return step(b"#1=CARTESIAN_POINT(''," + b"(" * (size // 2) + b")" * (size // 2) + b");\n")


@family("step one long name")
def _(size):
    return step(b"#1=CARTESIAN_POINT('" + b"a" * size + b"',(0.,1.,2.));\n")


@family("step an end that is missing")
def _(size):
    return step(b"/*" + b" " * size)


def iges(rows: list[bytes]) -> bytes:
    lines = [
        b"S".rjust(73) + b"      1",
        b"1H,,1H;,1Ha,1Ha,1Ha,1Ha,32,38,6,308,15,1Ha,1.,2,2HMM,1,1.;".ljust(72) + b"G      1",
    ]
    lines += rows
    return b"".join(line.ljust(80)[:80] + b"\n" for line in lines)


@family("iges entries without end")
def _(size):
    rows = []
    for k in range(max(1, size // 162)):
        rows.append(
            b"     116%8d       0       0       0       0       0       000000000D%7d"
            % (k, 2 * k + 1)
        )
        rows.append(
            b"     116       0       0       1       0                               0D%7d"
            % (2 * k + 2)
        )
    return iges(rows)


@family("iges blank lines")
def _(size):
    return iges([b""] * max(1, size // 81))


@family("iges one long number")
def _(size):
    return iges([b"1" * 64 + b"P%15d" % (k + 1) for k in range(max(1, size // 81))])
