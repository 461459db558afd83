// Puts the licence of three.js beside the built file, as the licence asks.
const { copyFileSync } = require("node:fs");
copyFileSync("node_modules/three/LICENSE", "../autobalance/report/assets/three.LICENSE.txt");
