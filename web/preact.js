// The parts of preact that the app's components use: rendering, hooks, and tags in template strings.
export { render } from "preact";
export { useEffect, useRef, useState } from "preact/hooks";
export { html } from "htm/preact";
