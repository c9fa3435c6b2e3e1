import js from "@eslint/js";
import globals from "globals";

export default [
  { ignores: ["vendor/"] },
  js.configs.recommended,
  {
    languageOptions: { ecmaVersion: 2024, globals: { ...globals.browser, model: "off" } },
    rules: {
      eqeqeq: "error",
      "no-control-regex": "off",
      "max-len": ["error", { code: 160, ignoreUrls: true }],
      "max-lines": ["error", 600],
      "no-unused-vars": ["error", { argsIgnorePattern: "^_" }],
      "no-var": "error",
      "prefer-const": ["error", { destructuring: "all" }],
    },
  },
  { files: ["tests/**", "eslint.config.js"], languageOptions: { globals: globals.node } },
];
