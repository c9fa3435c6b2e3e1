#!/usr/bin/env bash
# Builds the site of the documentation in target/site with mdBook: docs/site.sh [PROGRAM]
# The pages of help and settings are what the program prints; without PROGRAM, cargo builds it.
# Pages link to pictures and files all over the project, so mdBook is given a copy of all that links lead to.
set -euo pipefail
program=${1:+$(realpath "$1")}
cd "$(dirname "$0")/.."
command -v mdbook > /dev/null || { echo 'mdbook is missing: install it from https://rust-lang.github.io/mdBook' >&2; exit 1; }
if [ -z "$program" ]; then
  cargo build --release --locked --bin landscape
  program=$PWD/target/release/landscape
fi
book=target/book
rm -rf "$book" target/site
mkdir -p "$book/pages"
git ls-files -z -- . ':!tests' ':!Cargo.lock' | tar --null -T - -cf - | tar -xf - -C "$book/pages"
cp docs/book.toml docs/site.css "$book"
help=$(cd "$book/pages" && python3 "$OLDPWD/docs/help_pages.py" "$program" docs/help)
# The summary lists pages as seen from docs; mdBook wants them from the top of the copy. MdBook makes pages only of what the
# summary lists, so it is told of the summary itself and of each result, too.
sed -E -e 's#\]\(\.\./#](#; t' -e 's#\]\(#](docs/#' docs/SUMMARY.md | while IFS= read -r line; do
  printf '%s\n' "$line"
  case $line in
    '[Landscape]'*) printf '[All pages](docs/SUMMARY.md)\n' ;;
    *'(docs/commands.md)') printf '%s\n' "$help" ;;
    *'(figures/README.md)')
      for result in figures/*.md; do
        [ "$result" = figures/README.md ] || printf '  - [%s](%s)\n' "$(sed -n 's/^# //p' "$result" | head -n 1)" "$result"
      done ;;
  esac
done > "$book/pages/SUMMARY.md"
mdbook build "$book"
mv "$book/site" target/site
echo 'wrote target/site/index.html'
