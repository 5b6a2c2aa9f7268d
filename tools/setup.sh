# SPDX-License-Identifier: LGPL-2.1-or-later
# Sourced by tools/run and tools/test: installs missing packages and configures the build folder, $build.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=$root/build

say() {
  printf '== %s\n' "$*"
}

as_root() {
  if ((EUID == 0)); then "$@"; else sudo "$@"; fi
}

release=$(. /etc/os-release && echo "${VERSION_CODENAME:-}")
missing=()
for package in $(sed "s/#.*//; s/ *\[$release\]//; /\[/d" "$root/tools/debian-packages"); do
  status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  [[ $status == installed ]] || missing+=("$package")
done
if ((${#missing[@]})); then
  say "Installing ${#missing[@]} packages and what they need: ${missing[*]}"
  as_root apt-get -qq update
  as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get -qq -o Dpkg::Use-Pty=0 install --no-install-recommends "${missing[@]}" </dev/null >/dev/null
fi

if [[ ! -e $build/build.ninja ]]; then
  say "Configuring $build"
  cmake -S "$root" --preset release --log-level=WARNING
fi
