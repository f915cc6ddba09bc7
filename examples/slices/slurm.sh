#!/bin/bash
# One slice of 30 frames for each task of a Slurm array, on the servers that SERVERS lists:
#   sbatch --array=0-7 --export=ALL,SERVERS="http://a:8080 http://b:8080" slurm.sh SEQUENCE.json FOLDER
# Afterwards: slices.py join FOLDER OUTPUT.tar
#SBATCH --job-name=clerestory
#SBATCH --cpus-per-task=1
#SBATCH --mem=256M
#SBATCH --requeue
set -euo pipefail
exec "$SLURM_SUBMIT_DIR/slices.py" draw "$1" "$2" $((30 * SLURM_ARRAY_TASK_ID)) 30
