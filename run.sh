#!/usr/bin/env bash
# Installs what is missing, builds, lights the Cornell box by voxel cone tracing and by path tracing into out/, and prints
# the error. With arguments it passes them to the program instead: ./run.sh capture my.gltf --out out
set -euo pipefail
called_from=$PWD
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")"
root=$PWD
# shellcheck source=tools/packages.sh
. tools/packages.sh

install_packages "${voxcone_packages[@]}"
[ -f build/release/build.ninja ] || configure release -DVOXCONE_TESTS=OFF
# Silent when there is nothing to do.
ninja -C build/release -n voxcone | grep -q "no work to do" || ninja -C build/release voxcone >&2
voxcone=$root/build/release/voxcone

if [ $# -gt 0 ]; then
    cd "$called_from"
    exec "$voxcone" "$@"
fi

"$voxcone" capture assets/captures/cornell.json --out out/capture >/dev/null
"$voxcone" reference assets/captures/cornell.json --out out/reference >/dev/null
"$voxcone" compare out/reference out/capture --heatmap out/heatmap

echo
echo "Pictures:"
for folder in capture reference heatmap; do
    echo "  out/$folder/front/beauty.0000.png  indirect_diffuse.0000.png"
done
