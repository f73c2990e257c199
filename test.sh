#!/usr/bin/env bash
# Installs what is missing, builds, and runs all tests; then the malformed scenes again under AddressSanitizer and
# UndefinedBehaviorSanitizer.
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")"
# shellcheck source=tools/packages.sh
. tools/packages.sh

install_packages "${voxcone_packages[@]}" "${voxcone_test_packages[@]}"
configure release -DVOXCONE_TESTS=ON
ninja -C build/release
configure sanitize -DVOXCONE_TESTS=ON
ninja -C build/sanitize scene_malformed_test

status=0
ctest --test-dir build/release --output-on-failure || status=$?
ctest --test-dir build/sanitize --output-on-failure --tests-regex '^scene_malformed_test$' || status=$?
exit $status
