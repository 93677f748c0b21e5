#!/bin/sh
# run.sh PREFIX WORK COMPILER: builds the consumer with what pkg-config says of the package in PREFIX, and runs it.
set -eu
mkdir -p "$2"
export PKG_CONFIG_PATH="$1/lib/pkgconfig"
# shellcheck disable=SC2046
"$3" -Wall -Werror "$(dirname "$0")/../cmake-consumer/consumer.c" -o "$2/consumer" $(pkg-config --cflags --libs relievo)
[ "$(pkg-config --modversion relievo)" = "$(cd "$1/lib" && ls librelievo.so.*.*.* | sed 's/librelievo.so.//')" ]
LD_LIBRARY_PATH="$1/lib" "$2/consumer"
