#!/usr/bin/env bash
# report_pictures.sh BISS PAGE FOLDER
# Reports of a small and of a large capture as they look in Chromium and Firefox, and printed: pictures
# in FOLDER, to be looked at.
set -euo pipefail

biss=$1
page=$2
folder=$3
mkdir -p "$folder"
cd "$folder"
"$biss" simulate -f resolute-26 --cycles 60 --cable 10m --fault flip@7,bit=9 -o small.vcd
"$biss" simulate -f resolute-26 --cycles 20000 --cable 10m --jitter 2ns --fault flip:0.004 \
  --fault no_answer:0.001 -o large.vcd
profile=$(mktemp -d)
trap 'rm -rf "$profile"' EXIT
for name in small large; do
  "$biss" report "$name.vcd" -f resolute-26 --page "$page" -o "$name.html"
  address="file://$PWD/$name.html#panel=plots&format=resolute-26"
  if [ "$name" = large ]; then address="file://$PWD/$name.html"; fi
  chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --window-size=1400,900 \
    --virtual-time-budget=8000 --screenshot="$name-chromium.png" "$address" 2>/dev/null
  chromium --headless --no-sandbox --disable-gpu --virtual-time-budget=15000 --no-pdf-header-footer \
    --print-to-pdf="$name.pdf" "$address" 2>/dev/null
  pdftoppm -r 60 -png "$name.pdf" "$name-print"
  firefox-esr --headless --profile "$profile" --window-size=1400,900 \
    --screenshot "$PWD/$name-firefox.png" "$address" >/dev/null 2>&1
done
ls "$folder"
