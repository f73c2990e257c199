# shellcheck shell=bash disable=SC2034
# Sourced by run.sh and test.sh: the Debian 12 packages that voxcone needs, and a function that installs what is missing.

voxcone_packages=(cmake ninja-build g++ pkg-config libglm-dev libepoxy-dev libegl-dev libgl-dev libegl-mesa0 libgl1-mesa-dri
  libtinygltf-dev libstb-dev nlohmann-json3-dev libopenimageio-dev openimageio-tools libembree-dev libtbb-dev libcli11-dev
  libfmt-dev libssl-dev libglfw3-dev libimgui-dev)
voxcone_test_packages=(libgtest-dev libgmock-dev libbenchmark-dev parallel libx11-dev chromium xvfb xauth xdotool)

# install_packages NAME...: installs those that are missing, as root or by sudo without a password; else prints the one line
# to run and exits with 2.
install_packages() {
    local missing=() name
    for name in "$@"; do
        dpkg-query --show --showformat='${db:Status-Status}' "$name" 2>/dev/null | grep -qx installed || missing+=("$name")
    done
    [ ${#missing[@]} -eq 0 ] && return
    local sudo=""
    if [ "$(id -u)" -ne 0 ]; then
        if ! sudo -n true 2>/dev/null; then
            echo "Missing packages; install them with:" >&2
            echo "sudo apt-get update && sudo apt-get install -y --no-install-recommends ${missing[*]}" >&2
            exit 2
        fi
        sudo="sudo"
    fi
    echo "Installing ${missing[*]}" >&2
    $sudo apt-get update -qq
    $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >&2
}

# configure PRESET OPTION...: configures build/PRESET, with ccache where there is one.
configure() {
    local preset=$1
    shift
    local launcher=()
    command -v ccache >/dev/null && launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
    cmake --preset "$preset" "${launcher[@]}" "$@" >&2
}
