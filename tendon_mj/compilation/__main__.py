"""Compile the plugins now, so that no later import has to: ``python -m tendon_mj.compilation``.

The import of the package has compiled them before this runs; left to do is to say where they are.
"""

from tendon_mj.compilation import folders

kept = [folder for folder in folders.readable() if any(folder.glob("*.bin"))]
for folder in kept:
    files = list(folder.glob("*.bin"))
    size = sum(file.stat().st_size for file in files) / 1e6
    print(f"tendon_mj: {len(files)} compiled functions ({size:.1f} MB) in {folder}")
if not kept:
    print("tendon_mj: no machine code is kept")
