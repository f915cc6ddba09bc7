#!/bin/bash
# Requests one frame: frame.sh [SERVER] [SCENE] [FILE]. Retries while the scene loads and while the server is busy.
set -euo pipefail
server=${1:-http://localhost:8080} scene=${2:-chapel} file=${3:-frame.jpg}

request() {
  cat <<JSON
{ "scene": "$scene", "width": 640, "height": 360, "effects": { "emission": true }, "accuracy": "fine" }
JSON
}

headers=$(mktemp)
trap 'rm -f "$headers"' EXIT
for try in {1..60}; do
  status=$(request | curl -sS -D "$headers" -o "$file" -w '%{http_code}' \
    -H 'Content-Type: application/json' --data-binary @- "$server/v1/frames")
  case $status in
    200) break ;;
    409 | 429 | 503) sleep "$(awk -F': *' 'tolower($1) == "retry-after" { print $2 + 0; f = 1 } END { if (!f) print 1 }' "$headers")" ;;
    *) cat "$file" >&2; rm -f "$file"; exit 1 ;;  # a problem document that lists every wrong field
  esac
done
[[ $status == 200 ]] || { echo "the server is still busy; giving up" >&2; exit 1; }
echo "$file: $(awk -F': *' 'tolower($1) == "server-timing" { n = split($2, t, ", "); print t[n] }' "$headers" | tr -d '\r')"
