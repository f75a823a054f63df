#!/bin/sh
# Builds the Debian package of what is committed, into output/deb: sh packaging/build_deb.sh
set -eu
cd "$(dirname "$0")/.."
sh scripts/install_packages.sh dpkg-dev debhelper dh-python fakeroot lintian
rm -rf output/deb
mkdir -p output/deb/mlgimp
git archive HEAD | tar x -C output/deb/mlgimp
cp -r packaging/debian output/deb/mlgimp/debian
cd output/deb/mlgimp
dpkg-buildpackage -us -uc -b -j2
cd ..
lintian --fail-on error,warning ./*.changes
ls ./*.deb
