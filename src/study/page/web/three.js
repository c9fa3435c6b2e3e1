// The parts of three.js that the page uses. Their script stands before the page's own one (vendor/make.sh makes both).

/** @type {typeof import("three")} */
export const THREE = Reflect.get(globalThis, "THREE");
