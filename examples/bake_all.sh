#!/bin/sh
# Bakes every mesh of a folder with one material, only what is missing or older than mesh or recipe, as make would:
#     examples/bake_all.sh MESHES MATERIAL OUT
# A mesh that cannot be baked says why in a line, and the others go on. For many meshes `surftex batch` does
# the same with workers, manifests and a report.
set -u
if [ $# -ne 3 ]; then
    echo "usage: $0 MESHES MATERIAL OUT" >&2
    exit 2
fi
meshes=$1 material=$2 out=$3
failed=0
for mesh in "$meshes"/*.obj "$meshes"/*.glb "$meshes"/*.ply; do
    [ -e "$mesh" ] || continue
    folder=$out/$(basename "$mesh")-$(basename "${material%.toml}")
    if [ "$folder/report.json" -nt "$mesh" ] && { [ ! -e "$material" ] || [ "$folder/report.json" -nt "$material" ]; }; then
        echo "$folder: up to date"
        continue
    fi
    surftex bake "$mesh" --material "$material" --out "$folder" --overwrite ${BAKE_OPTIONS:-} || failed=1
done
exit $failed
