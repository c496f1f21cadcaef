#!/bin/sh
# The pictures of which the sheets of docs/btf.md consist, made by a given program: btf.sh PROGRAM FOLDER.
set -eu
program=$(realpath "$1")
mkdir -p "$2" && cd "$2"

# One cloth in all forms, under four pairs of light and view and on a sphere.
"$program" capture weave --size 64 --views 20 --lights 20 -o cloth.zip --format png --force
"$program" fit cloth.zip -o functions.exr --rank 32 --half --force
"$program" fit cloth.zip -o clusters.exr --rank 32 --clusters 16 --half --force
"$program" fit cloth.zip -o views.exr --model views-ptm --half --force
"$program" fit cloth.zip -o products.exr --model separable4 --half --force
"$program" fit cloth.zip -o lobes.exr --model lafortune2 --half --force
"$program" model cloth.zip -o fields.rlm --fields clusters --force
while read -r number light view; do
  for form in cloth.zip functions.exr clusters.exr views.exr products.exr lobes.exr fields.rlm; do
    "$program" relight "$form" --light="$light" --view="$view" -o "${form%.*}_$number.png" --force
  done
done <<PAIRS
1 0.35,0.35,0.87 0,0,1
2 -0.7,0.1,0.7 0.5,0.2,0.85
3 0.1,-0.8,0.6 -0.5,0.5,0.7
4 0.5,-0.3,0.8 0.2,-0.7,0.7
PAIRS
for form in functions.exr clusters.exr views.exr products.exr lobes.exr fields.rlm; do
  "$program" render "$form" --mesh sphere --tiling 2 --light=-0.5,0.5,0.7 --size 128x128 -o "${form%.*}_5.png" --force
done

# A measured weave and its functions.
"$program" capture weave --size 256 --views bonn -o weave.zip --force
"$program" fit weave.zip -o weave.exr --rank 32 --half --force
"$program" render weave.exr --mesh sphere --light=-0.5,0.5,0.7 --size 400x400 -o weave_sphere.png --force
for form in weave.exr weave.zip; do
  "$program" relight "$form" --light=-0.5,0.5,0.7 --view 0.8,0.1,0.6 -o "weave_${form#weave.}.png" --force
done

# A sample of a weave, and tiles made from it on a cloth seen from two sides.
"$program" capture weave --size 160 --feature 32 --views 20 --lights 20 -o sample.zip --format png --force
"$program" fit sample.zip -o sample.exr --rank 32 --rounding 0.004 --force
"$program" roll sample.exr -k 4 -o tiles.exr --force
"$program" synth tiles.exr --size 448 -o large.exr --force
"$program" relight sample.exr --light=-0.4,0.5,0.75 --view 0,0,1 -o sample.png --force
for camera in 0,0 50,20; do
  "$program" render large.exr --mesh cloth --tiling 1 --camera="$camera" --light=-0.4,0.5,0.75 --background 1,1,1 \
    --size 640x640 -o "cloth_$camera.png" --force
done
