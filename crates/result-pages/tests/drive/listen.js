"use strict";
// Errors of the page, from its first script on: thrown, printed, or requests that its policy forbids.
window.heard = [];
addEventListener("error", (event) => heard.push(`error: ${event.message}`));
addEventListener("unhandledrejection", (event) => heard.push(`rejection: ${event.reason}`));
addEventListener("securitypolicyviolation", (event) => heard.push(`request: ${event.violatedDirective} ${event.blockedURI}`));
for (const kind of ["error", "warn"]) console[kind] = (...words) => heard.push(`${kind}: ${words.join(" ")}`);
