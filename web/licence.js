// Puts the licences of what was built in beside the built files, as they ask.
const { copyFileSync, readFileSync, writeFileSync } = require("node:fs");
copyFileSync("node_modules/three/LICENSE", "../autobalance/report/assets/three.LICENSE.txt");
const parts = ["preact", "htm"].map((name) => `${name}\n\n${readFileSync(`node_modules/${name}/LICENSE`, "utf8").trim()}\n`);
writeFileSync("../autobalance/browser/static/preact.LICENSE.txt", parts.join(`\n${"-".repeat(72)}\n\n`));
