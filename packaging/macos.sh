#!/bin/sh
# Builds the library, the command and the module over OpenVDB on macOS, with what Homebrew has, into the folder `out` or the
# one that is named. Not tried: no machine with macOS is among the project's; see docs/platforms.md.
set -eu
cd "$(dirname "$0")/.."
out=${1:-out}

xcode-select --print-path > /dev/null || { echo "install the command-line tools: xcode-select --install" >&2; exit 1; }
command -v cargo > /dev/null || { echo "install Rust: https://rustup.rs" >&2; exit 1; }
command -v brew > /dev/null || { echo "install Homebrew: https://brew.sh" >&2; exit 1; }
brew install cmake ninja opensubdiv open-mesh embree openvdb

# OpenSubdiv and OpenMesh are linked. Build scripts look for their headers and libraries here.
prefix=$(brew --prefix)
export RELIEVO_PREFIX="$prefix"
cargo build --release --package relievo-capi --package relievo-cli
cmake -S cpp/openvdb -B target/openvdb -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$prefix"
cmake --build target/openvdb

# The library's install name has its minor version, as the SONAME on Linux has.
version=$(sed -n 's/^#define RLV_VERSION_M[A-Z]*OR \([0-9]*\)$/\1/p' include/relievo/version.h | paste -s -d . -)
mkdir -p "$out/bin" "$out/lib" "$out/include"
cp target/release/librelievo.dylib "$out/lib/librelievo.$version.dylib"
ln -sf "librelievo.$version.dylib" "$out/lib/librelievo.dylib"
cp target/openvdb/librelievo_openvdb.so "$out/lib/"
cp target/release/relievo "$out/bin/"
cp -R include/relievo "$out/include/"
otool -L "$out/lib/librelievo.$version.dylib"
"$out/bin/relievo" --version
