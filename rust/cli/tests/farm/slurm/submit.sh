#!/bin/sh
# Submits the stages of the job and prints their numbers.
set -eu
cd "$(dirname "$0")"
simulate=$(sbatch --parsable simulate.sbatch)
echo "simulate $simulate"
mesh=$(sbatch --parsable --dependency=afterok:"${simulate%%;*}" --kill-on-invalid-dep=yes mesh.sbatch)
echo "mesh $mesh"
foam=$(sbatch --parsable --dependency=afterok:"${simulate%%;*}" --kill-on-invalid-dep=yes foam.sbatch)
echo "foam $foam"
render=$(sbatch --parsable --dependency=afterok:"${foam%%;*}" --kill-on-invalid-dep=yes render.sbatch)
echo "render $render"
