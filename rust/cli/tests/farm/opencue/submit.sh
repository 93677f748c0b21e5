#!/bin/sh
# Launches the job with PyOutline, on the Cuebot at $CUEBOT_HOSTS, in the show $SHOW and the shot $SHOT.
set -eu
exec python3 "$(dirname "$0")/job.py"
