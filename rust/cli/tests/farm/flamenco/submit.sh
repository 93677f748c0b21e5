#!/bin/sh
# Submits the job to the Flamenco Manager at $FLAMENCO_MANAGER. Its folder `scripts` needs relievo.js, which lies beside this.
set -eu
exec curl --fail --silent --show-error --header 'Content-Type: application/json' \
    --data-binary "@$(dirname "$0")/job.json" "${FLAMENCO_MANAGER:-http://localhost:8080}/api/v3/jobs"
