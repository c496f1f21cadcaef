#!/bin/sh
# The textures of the sheets "before" and "after" of docs/methods.md, made by a given program, so that two versions can
# be compared: sheets.sh PROGRAM FOLDER makes FOLDER/exemplars where it is missing, and a folder named like the program.
set -eu
program=$(realpath "$1")
mkdir -p "$2" && cd "$2"
name=$(basename "$program")

# A photograph of a built-in material under one light from the upper left: name, material, side, feature size.
exemplar() {
  [ ! -e "exemplars/$1.png" ] || return 0
  mkdir -p exemplars
  "$program" capture "$2" -o capture --force --lights 4 --size "$3" --feature "$4"
  cp capture/light_001.png "exemplars/$1.png"
}
exemplar 1 pebbles 192 72
exemplar 2 sponge 128 24
exemplar 3 marble 192 64
exemplar 4 leather 192 32
exemplar 5 bark 160 24
exemplar 6 bark 160 24
exemplar 7 marble 192 48
exemplar 9 fire 192 32
exemplar 10 weave 80 40
if [ ! -e exemplars/8.png ]; then
  "$program" procedural pebbles -o maps --force --size 160 --feature 32
  cp maps/albedo.png exemplars/8.png
  cp maps/height.png exemplars/8_height.png
fi

rm -rf "$name" && mkdir "$name"
# A texture of 256 x 256 from an exemplar: number, options.
synth() {
  number=$1
  shift
  "$program" synth "exemplars/$number.png" -o "$name/$number.png" --seed 1 --force --size "${size:-256}" "$@"
}
synth 1
synth 2 --method wei-levoy
synth 3 --method auto
synth 4 --method patchmatch
size=129 synth 5 --method patchmatch --tile
synth 6 --method roller --tiles 16
"$program" tileable exemplars/7.png -o "$name/7.png" --force
"$program" synth exemplars/8.png -o "$name/8_albedo.png" --size 256 --seed 1 --force \
  --apply exemplars/8_height.png --apply-dir "$name"
mv "$name/8_height.png" "$name/8.png"
synth 9 --method auto
if "$program" synth --help | grep -q elements; then synth 10 --method elements; else synth 10; fi
