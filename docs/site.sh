#!/usr/bin/env bash
# Builds the site of the documentation in target/site with mdBook: docs/site.sh
# Pages link to pictures and files all over the project, so mdBook is given a copy of all that links lead to.
set -euo pipefail
cd "$(dirname "$0")/.."
command -v mdbook > /dev/null || { echo 'mdbook is missing: install it from https://rust-lang.github.io/mdBook' >&2; exit 1; }
book=target/book
rm -rf "$book" target/site
mkdir -p "$book/pages"
git ls-files -z -- . ':!tests' ':!Cargo.lock' | tar --null -T - -cf - | tar -xf - -C "$book/pages"
cp docs/book.toml "$book"
# The summary lists pages as seen from docs; mdBook wants them from the top of the copy.
sed -E -e 's#\]\(\.\./#](#; t' -e 's#\]\(#](docs/#' docs/SUMMARY.md > "$book/pages/SUMMARY.md"
mdbook build "$book"
mv "$book/site" target/site
echo 'wrote target/site/index.html'
