#!/bin/bash
# Draws FRAMES frames in slices of SIZE on several servers with GNU parallel, two slices for each server at a time, and joins
# them. Run it again after an interruption: slices that exist are kept.
#   SERVERS="http://a:8080 http://b:8080" parallel.sh SEQUENCE.json FRAMES SIZE FOLDER OUTPUT.tar
set -euo pipefail
slices="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/slices.py"
sequence=$1 frames=$2 size=$3 folder=$4 output=$5
read -ra servers <<<"${SERVERS:?lists the addresses of servers, separated by spaces}"
export SERVERS
seq 0 "$size" $((frames - 1)) |
  parallel --will-cite --jobs $((2 * ${#servers[@]})) --halt now,fail=1 "$slices" draw "$sequence" "$folder" {} "$size"
exec "$slices" join "$folder" "$output"
