#!/bin/sh
# run.sh PREFIX WORK COMPILER: builds the consumer with what pkg-config says of the package in PREFIX, and runs it: with
# the shared library, and with the static one where that is installed.
set -eu
mkdir -p "$2"
export PKG_CONFIG_PATH="$1/lib/pkgconfig"
# shellcheck disable=SC2046
"$3" -Wall -Werror "$(dirname "$0")/../cmake-consumer/consumer.c" -o "$2/consumer" $(pkg-config --cflags --libs relievo)
[ "$(pkg-config --modversion relievo)" = "$(cd "$1/lib" && ls librelievo.so.*.*.* | sed 's/librelievo.so.//')" ]
LD_LIBRARY_PATH="$1/lib" "$2/consumer"
[ -f "$1/lib/librelievo.a" ] || exit 0
# A folder without the shared library, which the linker would prefer.
rm -rf "$2/static"
mkdir -p "$2/static/lib"
cp -r "$1/include" "$2/static"
cp -r "$1/lib/pkgconfig" "$1/lib/librelievo.a" "$2/static/lib"
export PKG_CONFIG_PATH="$2/static/lib/pkgconfig"
# shellcheck disable=SC2046
"$3" -Wall -Werror "$(dirname "$0")/../cmake-consumer/consumer.c" -o "$2/static/consumer" \
    $(pkg-config --static --cflags --libs relievo)
"$2/static/consumer"
