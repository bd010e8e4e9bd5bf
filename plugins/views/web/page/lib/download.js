// @ts-check
// Saves files from the browser.

/**
 * Saves a file by a download of the browser.
 * @param {Blob} blob
 * @param {string} name name of the file
 */
export function download(blob, name) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
