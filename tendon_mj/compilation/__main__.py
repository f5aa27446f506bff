"""Compile the plugins now, so that no later import has to: ``python -m tendon_mj.compilation``.

The import of the package has compiled them before this runs; this prints where they are.
"""

from tendon_mj.compilation import folders

kept = {folder: list(folder.glob("*.bin")) for folder in folders.readable()}
for folder, files in kept.items():
    if files:
        size = sum(file.stat().st_size for file in files) / 1e6
        print(f"tendon_mj: {len(files)} compiled functions ({size:.1f} MB) in {folder}")
if not any(kept.values()):
    print("tendon_mj: no machine code is kept")
