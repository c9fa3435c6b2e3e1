#!/usr/bin/env bash
# Makes the scripts of the page: the parts of three.js that it uses, and the bundle of the modules in `web`. Needs npm and its
# registry. SHA256SUMS says afterwards what these files and the modules were, so that a test finds modules that were changed
# without running this.
set -euo pipefail
export LC_ALL=C
cd "$(dirname "$0")/.."
[ -d node_modules ] || npm ci --ignore-scripts --no-audit --no-fund
three=$(node -p 'require("./package.json").devDependencies.three')
esbuild() { node_modules/.bin/esbuild --bundle --minify --format=iife --target=es2022 --log-level=warning "$@"; }

esbuild --global-name=THREE --charset=ascii --legal-comments=inline --outfile="vendor/three-$three.min.js" <<'PARTS'
export {
  BufferAttribute, BufferGeometry, Color, ConeGeometry, CylinderGeometry, DirectionalLight, DoubleSide, FrontSide, Group,
  HemisphereLight, InstancedMesh, Matrix4, Mesh, MeshLambertMaterial, OrthographicCamera, Quaternion, Scene, SphereGeometry,
  Vector3, WebGLRenderer,
} from "three";
PARTS
cp node_modules/three/LICENSE vendor/LICENSE
esbuild web/main.js --charset=utf8 --outfile=vendor/page.min.js

cd vendor
sha256sum LICENSE "three-$three.min.js" page.min.js ../web/*.js > SHA256SUMS
